/// From a finished record to everything that a run leaves behind.
#pragma once

#include "pipeline/run.h"

namespace loopline {

/// Compares the result with the truth, if there is one, and writes the run directory but for pictures and the
/// report.
void write_results(const RunSetup& setup, RunRecord& record, WorkerState* state);

/// Pictures and the report: last, so that whatever happens to them, the numbers are on disk already.
void draw_results(const RunSetup& setup, RunRecord& record, WorkerState* state);

}  // namespace loopline
