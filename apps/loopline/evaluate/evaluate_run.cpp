#include "evaluate/evaluate_run.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "evaluate/absolute_error.h"
#include "evaluate/consistency.h"
#include "gnss/geo_reference.h"

namespace loopline {

namespace {

constexpr double max_difference_s = 0.1;  // to the nearest truth: references of 10 Hz and more are fully used

bool is_finite(const Pose3& pose) {
    return pose.translation_m.allFinite() && pose.rotation.coeffs().allFinite();
}

/// Latest revision of the finite poses, each with that of the truth; estimate_index is that of the
/// trajectory.
void pair_with_truth(const Trajectory& trajectory, const EvaluationReference& reference, PosePairs& pairs) {
    const Pose3 T_base_point(Pose2{reference.truth_point_m.x(), reference.truth_point_m.y(), 0});
    const bool moved = !reference.truth_has_orientation && !reference.truth_point_m.isZero();
    ReferencePoses truth(
        reference.truth, max_difference_s,
        reference.truth_has_orientation ? ReferencePoses::Kind::poses_between : ReferencePoses::Kind::positions);
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
        const TrajectoryEntry entry = trajectory[i];
        if (!is_finite(entry.T_map_base)) continue;
        if (const auto true_pose = truth.at(entry.stamp_ns))
            pairs.push_back(
                {entry.stamp_ns, i, moved ? entry.T_map_base * T_base_point : entry.T_map_base, *true_pose});
    }
}

/// Distances without any alignment.
void compare_on_earth(const PosePairs& pairs, const Pose3& T_map_ref,
                      std::map<std::string, MetricValue>& metrics) {
    double horizontal = 0, vertical = 0, most = 0;
    for (const PosePair pair : pairs) {
        const Eigen::Vector3d e_m =
            pair.T_map_base_estimate.translation_m - T_map_ref * pair.T_ref_base_reference.translation_m;
        horizontal += e_m.head<2>().squaredNorm();
        vertical += e_m.z() * e_m.z();
        most = std::max(most, e_m.norm());
    }
    const auto n = static_cast<double>(pairs.size());
    metrics["earth_rmse_m"] = std::sqrt((horizontal + vertical) / n);
    metrics["earth_horizontal_rmse_m"] = std::sqrt(horizontal / n);
    metrics["earth_vertical_rmse_m"] = std::sqrt(vertical / n);
    metrics["earth_max_m"] = most;
}

void compare_with_truth(const Trajectory& trajectory, const EvaluationReference& reference,
                        const std::filesystem::path& scratch_folder, const std::optional<EarthFrame>& earth,
                        RunEvaluation& evaluation) {
    PosePairs pairs;
    pairs.keep_in(scratch_folder);
    pair_with_truth(trajectory, reference, pairs);
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
    const PosePair first = pairs[0];
    const bool on_earth = earth && reference.surveyed.earth;
    const Pose3 T_map_ref =
        on_earth ? gnss::T_between(gnss::GeoReference(*earth), gnss::GeoReference(*reference.surveyed.earth))
                 : first.T_map_base_estimate * first.T_ref_base_reference.inverse();
    if (on_earth) compare_on_earth(pairs, T_map_ref, metrics);
    const PosePair last = pairs[pairs.size() - 1];
    metrics["end_error_m"] =
        (last.T_map_base_estimate.translation_m - T_map_ref * last.T_ref_base_reference.translation_m).norm();

    double nees_sum = 0;
    std::int64_t nees_count = 0;
    for (const PosePair pair : pairs) {
        const auto nees =
            pose_nees(pair.T_map_base_estimate.planar(), (T_map_ref * pair.T_ref_base_reference).planar(),
                      trajectory[pair.estimate_index].covariance.planar());
        if (nees) nees_sum += *nees, ++nees_count;
    }
    if (nees_count > 0) metrics["nees_mean"] = nees_sum / static_cast<double>(nees_count);
}

void compare_with_relations(const Trajectory& trajectory, const EvaluationReference& reference,
                            RunEvaluation& evaluation) {
    std::vector<StampedPose> poses;
    for (const TrajectoryEntry entry : trajectory.entries())
        if (is_finite(entry.T_map_base)) poses.push_back({entry.stamp_ns, entry.T_map_base});
    const RelationsError error = relations_error(reference.relations, std::move(poses), {});
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
                           const std::shared_ptr<const EvaluationReference>& reference,
                           const std::filesystem::path& scratch_folder,
                           const std::optional<EarthFrame>& earth) {
    RunEvaluation evaluation;
    if (!reference) return evaluation;
    if (!reference->truth.empty())
        compare_with_truth(trajectory, *reference, scratch_folder, earth, evaluation);
    if (!reference->relations.empty()) compare_with_relations(trajectory, *reference, evaluation);
    return evaluation;
}

}  // namespace loopline
