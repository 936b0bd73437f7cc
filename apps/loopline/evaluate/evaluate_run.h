/// How good is a run's trajectory? Its metrics against the [evaluation] truth and relations of the
/// experiment.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "api/results.h"
#include "api/trajectory.h"
#include "config/experiment.h"

namespace loopline {

struct EvaluationReference;  ///< truth and relations, read

/// Reads the files of [evaluation]: call it before the run, so that a file that can't be used is known early.
/// Null if there are none. Throws CommandError(exit_input_data), one sentence with file:line.
std::shared_ptr<const EvaluationReference> load_evaluation_reference(const EvaluationSettings& settings);

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
/// rigid alignment. nees_mean is of (x, y, heading): 3 if the covariances are right.
RunEvaluation evaluate_run(const Trajectory& trajectory,
                           const std::shared_ptr<const EvaluationReference>& reference);

}  // namespace loopline
