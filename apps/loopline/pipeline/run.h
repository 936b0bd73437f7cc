/// A run: one pass over the log for the estimate, a second one that draws the maps from it, and the results.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>

#include "config/experiment.h"
#include "evaluate/evaluate_run.h"
#include "pipeline/run_record.h"
#include "pipeline/supervisor.h"

namespace loopline {

class Checkpoint;
class RunScratch;

struct RunSetup {
    Experiment experiment;
    std::filesystem::path folder;  ///< the run directory; made when there is something to write
    std::shared_ptr<const EvaluationReference> reference;
    RunScratch* scratch = nullptr;  ///< null: what is set aside stays in memory
    int threads = 1;
    bool quiet = false;
    bool calibrates = false;  ///< the run is for Results::calibrations, and leaves no checkpoint
    std::chrono::steady_clock::time_point start;
    /// Of loading the program and the experiment, before the worker began.
    double cpu_before_s = 0, peak_before_mb = 0;
    /// Where to go on; null: from the beginning.
    std::shared_ptr<const Checkpoint> checkpoint;
};

/// Runs the experiment in this process and writes its results; returns the exit code. Throws CommandError if
/// there is nothing to write: no observation, or none that a module needs.
int run_experiment(const RunSetup& setup, const Attempt& attempt);

/// What a user must know goes to stderr, quiet or not.
void tell_problems(const RunRecord& record);

/// Times and memory so far.
void set_cost(RunRecord& record, const RunSetup& setup);

}  // namespace loopline
