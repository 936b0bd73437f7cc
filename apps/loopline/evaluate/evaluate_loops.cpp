#include "evaluate/evaluate_loops.h"

#include <cmath>
#include <map>
#include <optional>

#include "evaluate/association.h"

namespace loopline {
namespace {

constexpr double wrong_m = 0.5, wrong_rad = 5 * 3.14159265358979323846 / 180;
constexpr double max_truth_difference_s = 0.1;

struct PoseAndTruth {
    std::optional<Pose3> T_map_base, T_ref_base;
};

/// Of the stamps that loops name.
std::map<StampNs, PoseAndTruth> poses_at(const std::vector<LoopDecision>& loops, const Trajectory& trajectory,
                                         const EvaluationReference& reference) {
    std::map<StampNs, PoseAndTruth> poses;
    for (const LoopDecision& loop : loops)
        if (loop.accepted) poses[loop.stamp_ns], poses[loop.old_stamp_ns];
    if (poses.empty()) return poses;
    for (const TrajectoryEntry entry : trajectory.entries())
        if (const auto found = poses.find(entry.stamp_ns); found != poses.end())
            found->second.T_map_base = entry.T_map_base;
    ReferencePoses truth(reference.truth, max_truth_difference_s, ReferencePoses::Kind::poses);
    for (auto& [stamp_ns, pose] : poses) pose.T_ref_base = truth.at(stamp_ns);
    return poses;
}

bool is_wrong(const PoseAndTruth& old_pose, const PoseAndTruth& late) {
    const Pose2 found = (old_pose.T_map_base->inverse() * *late.T_map_base).planar(),
                real = (old_pose.T_ref_base->inverse() * *late.T_ref_base).planar(),
                off = real.inverse() * found;
    return std::hypot(off.x_m, off.y_m) > wrong_m || std::abs(off.phi_rad) > wrong_rad;
}

}  // namespace

RunEvaluation evaluate_loops(const std::vector<LoopDecision>& loops, const Trajectory& trajectory,
                             const std::shared_ptr<const EvaluationReference>& reference) {
    RunEvaluation evaluation;
    if (!reference || reference->truth.empty() || !reference->truth_has_orientation) return evaluation;
    const auto poses = poses_at(loops, trajectory, *reference);
    std::int64_t right = 0, wrong = 0;
    for (const LoopDecision& loop : loops) {
        if (!loop.accepted) continue;
        const PoseAndTruth &old_pose = poses.at(loop.old_stamp_ns), &late = poses.at(loop.stamp_ns);
        if (!old_pose.T_map_base || !old_pose.T_ref_base || !late.T_map_base || !late.T_ref_base) continue;
        ++(is_wrong(old_pose, late) ? wrong : right);
    }
    if (!loops.empty()) {
        evaluation.metrics["loops_right"] = right;
        evaluation.metrics["loops_wrong"] = wrong;
    }
    return evaluation;
}

}  // namespace loopline
