/// From a finished record to everything that a run leaves behind.
#pragma once

#include "pipeline/run.h"

namespace loopline {

/// Compares the result with the truth, if there is one, and writes the run directory, the pictures and the
/// report.
void write_outputs(const RunSetup& setup, RunRecord& record, WorkerState* state);

}  // namespace loopline
