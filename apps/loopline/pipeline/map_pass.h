/// The second pass over the log, in which the map builders draw from the final trajectory: nobody keeps a
/// private copy of old poses.
#pragma once

#include <cstdint>

#include "pipeline/run.h"

namespace loopline {

/// Draws the maps of the first `items` of the log into record.results, and for "before" pictures the points
/// by dead reckoning into record.odometry_results. Does nothing if no output needs maps or there is no
/// trajectory.
void map_pass(const RunSetup& setup, const Attempt& attempt, std::uint64_t items, RunRecord& record);

}  // namespace loopline
