/// What `loopline evaluate` prints: a table to read, or flat JSON keys that other programs rely on.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "evaluate/absolute_error.h"
#include "evaluate/kitti_segments.h"
#include "evaluate/relations.h"
#include "evaluate/relative_error.h"

namespace loopline {

struct EvaluationReport {
    std::size_t poses_estimate = 0, poses_reference = 0, poses_matched = 0;
    double way_m = 0;  ///< along the matched reference poses
    std::optional<AbsoluteError> absolute;
    std::optional<RelativeError> relative;
    std::optional<KittiError> kitti;
    std::optional<RelationsError> relations;
};

/// One object; keys that do not apply are absent.
std::string report_json(const EvaluationReport& report);
/// `rpe_step` is how the table names the step ("1 pose").
std::string report_text(const EvaluationReport& report, const std::string& rpe_step);

}  // namespace loopline
