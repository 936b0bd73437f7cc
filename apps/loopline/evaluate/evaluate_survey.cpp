/// Feature points and survey clouds as figures of a run.
#include <cmath>
#include <cstdint>

#include "evaluate/cloud_distance.h"
#include "evaluate/evaluate_run.h"
#include "evaluate/statistics.h"

namespace loopline {
namespace {

void add_figures(const std::vector<double>& errors_m, const std::string& prefix,
                 std::map<std::string, MetricValue>& metrics) {
    if (errors_m.empty()) return;
    const Statistics statistics = statistics_of(errors_m);
    metrics[prefix + "mean_error_m"] = statistics.mean;
    metrics[prefix + "rms_error_m"] = statistics.rmse;
    metrics[prefix + "max_error_m"] = statistics.max;
}

void add_distance(const Results& results, const std::string& suffix, const Trajectory* trajectory,
                  TruePath& truth, const SurveyedTruth& surveyed,
                  std::map<std::string, MetricValue>& metrics) {
    if (trajectory == nullptr) return;
    for (const NamedMap& named : results.maps) {
        const auto cloud = std::dynamic_pointer_cast<mrpt::maps::CPointsMap>(named.map);
        if (!cloud || !named.survey) continue;
        const auto T_map_truth = map_from_truth(*trajectory, truth);
        if (!T_map_truth) continue;
        const CloudDistance distance = cloud_to_walls(*cloud, T_map_truth->inverse(), surveyed);
        if (distance.points == 0) continue;
        const std::string name = named.name + suffix;
        metrics[name + "_median_m"] = distance.median_m;
        metrics[name + "_p95_m"] = distance.percentile_95_m;
        if (suffix.empty()) metrics[name + "_wall_points"] = static_cast<std::int64_t>(distance.points);
    }
}

}  // namespace

RunEvaluation evaluate_points(const std::vector<PointEstimate>& points, const std::vector<int>& missed) {
    RunEvaluation evaluation;
    std::vector<double> errors_m, true_pose_errors_m, odometry_errors_m;
    for (const PointEstimate& point : points) {
        errors_m.push_back(point.estimate_error_m());
        true_pose_errors_m.push_back((point.by_true_poses_m - point.true_m).norm());
        if (const auto error_m = point.odometry_error_m()) odometry_errors_m.push_back(*error_m);
    }
    if (!points.empty()) evaluation.metrics["points_used"] = static_cast<std::int64_t>(points.size());
    add_figures(errors_m, "points_", evaluation.metrics);
    add_figures(true_pose_errors_m, "points_true_poses_", evaluation.metrics);
    add_figures(odometry_errors_m, "points_odometry_", evaluation.metrics);
    if (missed.empty()) return evaluation;
    std::string numbers;
    for (const int number : missed) numbers += (numbers.empty() ? "" : ", ") + std::to_string(number);
    evaluation.warnings.push_back("no laser return with a pose hits feature point " + numbers +
                                  "; feature_points.csv is without it");
    return evaluation;
}

RunEvaluation evaluate_surveys(const Results& results, const Results& odometry_results,
                               const Trajectory& estimate, const Trajectory* odometry,
                               const EvaluationReference& reference) {
    RunEvaluation evaluation;
    if (reference.surveyed.walls.empty() || reference.truth.empty()) return evaluation;
    TruePath truth(std::shared_ptr<const StampedPath>(std::shared_ptr<void>(), &reference.truth));
    add_distance(results, "", &estimate, truth, reference.surveyed, evaluation.metrics);
    add_distance(odometry_results, "_odometry", odometry, truth, reference.surveyed, evaluation.metrics);
    return evaluation;
}

}  // namespace loopline
