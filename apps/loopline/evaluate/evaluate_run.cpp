#include "evaluate/evaluate_run.h"

#include <cmath>
#include <cstdint>

#include "evaluate/absolute_error.h"
#include "evaluate/consistency.h"

namespace loopline {

namespace {

constexpr double max_difference_s = 0.1;  // to the nearest truth: references of 10 Hz and more are fully used

struct FinitePoses {
    std::vector<StampedPose> poses;             ///< latest revision; those that are finite
    std::vector<const TrajectoryEntry*> entry;  ///< of each pose
};

FinitePoses latest_estimate(const Trajectory& trajectory) {
    FinitePoses estimate;
    estimate.poses.reserve(trajectory.size());
    estimate.entry.reserve(trajectory.size());
    for (const auto& entry : trajectory.entries()) {
        if (!entry.T_map_base.translation_m.allFinite() || !entry.T_map_base.rotation.coeffs().allFinite())
            continue;
        estimate.poses.push_back({entry.stamp_ns, entry.T_map_base});
        estimate.entry.push_back(&entry);
    }
    return estimate;
}

std::vector<PosePair> pairs_with_truth(const FinitePoses& estimate, const EvaluationReference& reference) {
    if (reference.truth_has_orientation)
        return associate_by_stamp(estimate.poses, reference.truth, max_difference_s);
    return associate_positions(way_of_point(estimate.poses, reference.truth_point_m), reference.truth,
                               max_difference_s);
}

void compare_with_truth(const FinitePoses& estimate, const EvaluationReference& reference,
                        RunEvaluation& evaluation) {
    const auto pairs = pairs_with_truth(estimate, reference);
    if (pairs.empty()) {
        evaluation.warnings.push_back("no pose of the run is within " +
                                      std::to_string(max_difference_s).substr(0, 3) +
                                      " s of a pose of the truth " + reference.truth_path);
        return;
    }
    auto& metrics = evaluation.metrics;
    const AbsoluteError ate = absolute_error(pairs, Alignment::automatic);
    metrics["truth_poses_used"] = static_cast<std::int64_t>(pairs.size());
    metrics["ate_rmse_m"] = ate.distance_m.rmse;
    metrics["ate_mean_m"] = ate.distance_m.mean;
    metrics["ate_median_m"] = ate.distance_m.median;
    metrics["ate_max_m"] = ate.distance_m.max;

    if (!reference.truth_has_orientation) return;

    // A run's map frame is its first pose: the truth is brought there by that pose alone.
    const Pose3 T_map_ref = pairs[0].T_map_base_estimate * pairs[0].T_ref_base_reference.inverse();
    const PosePair& last = pairs.back();
    metrics["end_error_m"] =
        (last.T_map_base_estimate.translation_m - T_map_ref * last.T_ref_base_reference.translation_m).norm();

    double nees_sum = 0;
    std::int64_t nees_count = 0;
    for (const auto& pair : pairs) {
        const auto nees =
            pose_nees(pair.T_map_base_estimate.planar(), (T_map_ref * pair.T_ref_base_reference).planar(),
                      estimate.entry[pair.estimate_index]->covariance.planar());
        if (nees) nees_sum += *nees, ++nees_count;
    }
    if (nees_count > 0) metrics["nees_mean"] = nees_sum / static_cast<double>(nees_count);
}

void compare_with_relations(const FinitePoses& estimate, const EvaluationReference& reference,
                            RunEvaluation& evaluation) {
    const RelationsError error = relations_error(reference.relations, estimate.poses, {});
    evaluation.metrics["relations_used"] = static_cast<std::int64_t>(error.translation_m.count);
    if (error.translation_m.count == 0) {
        evaluation.warnings.push_back("no relation of " + reference.relations_path +
                                      " lies within the time of the run");
        return;
    }
    evaluation.metrics["relations_translation_mean_m"] = error.translation_m.mean;
    evaluation.metrics["relations_translation_max_m"] = error.translation_m.max;
    evaluation.metrics["relations_rotation_mean_deg"] = error.rotation_deg.mean;
    evaluation.metrics["relations_rotation_max_deg"] = error.rotation_deg.max;
}

}  // namespace

RunEvaluation evaluate_run(const Trajectory& trajectory,
                           const std::shared_ptr<const EvaluationReference>& reference) {
    RunEvaluation evaluation;
    if (!reference) return evaluation;
    const FinitePoses estimate = latest_estimate(trajectory);
    if (!reference->truth.empty()) compare_with_truth(estimate, *reference, evaluation);
    if (!reference->relations.empty()) compare_with_relations(estimate, *reference, evaluation);
    return evaluation;
}

}  // namespace loopline
