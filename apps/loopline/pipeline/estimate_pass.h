/// The pass over the log in which the modules estimate.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/run.h"

namespace loopline {

/// Fills `record` with everything but the maps, the evaluation and the costs. Returns the number of items
/// that went through the chain: the second pass ends there too.
std::uint64_t estimate_pass(const RunSetup& setup, const Attempt& attempt, RunRecord& record);

}  // namespace loopline
