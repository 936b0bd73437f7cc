/// How good is a run's trajectory? Its metrics against the [evaluation] truth and relations of the
/// experiment.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "api/results.h"
#include "api/trajectory.h"
#include "evaluate/evaluation_reference.h"
#include "evaluate/feature_points.h"

namespace loopline {

struct RunEvaluation {
    /// Flat keys of metrics.json: ate_rmse_m ate_max_m ate_mean_m ate_median_m end_error_m nees_mean
    /// truth_poses_used, relations_translation_mean_m relations_rotation_mean_deg relations_used and more;
    /// absent where they do not apply.
    std::map<std::string, MetricValue> metrics;
    /// Why there are no such metrics, a sentence each: no pose shares its time with the truth, no usable
    /// relation.
    std::vector<std::string> warnings;
};

/// Compares the latest revision of `trajectory` with `reference`; a null reference gives nothing. Does not
/// throw. end_error_m and nees_mean are taken with the first common pose made equal, ate_* after the best
/// rigid alignment. nees_mean is of (x, y, heading): 3 if the covariances are right. Pairs of poses are kept
/// in a folder that may have to be made meanwhile, or in memory if it has no name. Where both frames are
/// known on the Earth, `earth` being the trajectory's, nothing is made equal for end_error_m and nees_mean,
/// and earth_rmse_m, earth_max_m, earth_horizontal_rmse_m, earth_vertical_rmse_m are distances as they are.
RunEvaluation evaluate_run(const Trajectory& trajectory,
                           const std::shared_ptr<const EvaluationReference>& reference,
                           const std::filesystem::path& scratch_folder = {},
                           const std::optional<EarthFrame>& earth = {});

/// Of feature points: points_mean_error_m points_rms_error_m points_max_error_m, points_odometry_* of dead
/// reckoning, and points_used; and a warning for those that were missed.
RunEvaluation evaluate_points(const std::vector<PointEstimate>& points, const std::vector<int>& missed);

/// Of survey clouds against the true walls of `reference`: NAME_median_m and NAME_p95_m of the corrected one,
/// NAME_odometry_median_m and NAME_odometry_p95_m of that by dead reckoning, NAME_wall_points.
RunEvaluation evaluate_surveys(const Results& results, const Results& odometry_results,
                               const Trajectory& estimate, const Trajectory* odometry,
                               const EvaluationReference& reference);

}  // namespace loopline
