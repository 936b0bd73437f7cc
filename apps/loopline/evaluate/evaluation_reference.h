/// What a run is compared with: the files of [evaluation], read.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "evaluate/relations.h"
#include "evaluate/surveyed_truth.h"
#include "output/tum.h"

namespace loopline {

/// Figures of another work for the same feature points, shown beside those of the run.
struct PublishedPoint {
    int number = 0;
    Eigen::Vector2d odometry_m = Eigen::Vector2d::Zero(), estimate_m = Eigen::Vector2d::Zero();
};

struct EvaluationReference {
    StampedPath truth;  ///< of base, or positions alone, of truth_point_m
    bool truth_has_orientation = true;
    Eigen::Vector2d truth_point_m = Eigen::Vector2d::Zero();  ///< in base; zero where the truth is that of base
    std::string truth_path;
    std::vector<Relation> relations;
    std::string relations_path;
    SurveyedTruth surveyed;
    std::vector<PublishedPoint> published;
    double scan_duration_s = 0;
};

/// The truth of a reference, which lives as long as this does.
inline std::shared_ptr<const StampedPath> truth_of(
    const std::shared_ptr<const EvaluationReference>& reference) {
    return {reference, &reference->truth};
}

/// Reads the files of [evaluation]: call it before the run, so that a file that can't be used is known early.
/// Null if there are none. Throws CommandError(exit_input_data), one sentence with file:line. The truth is kept
/// in a folder that may have to be made, or in memory if it has no name.
std::shared_ptr<const EvaluationReference> load_evaluation_reference(
    const EvaluationSettings& settings, const std::filesystem::path& scratch_folder = {});

}  // namespace loopline
