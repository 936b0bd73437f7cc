/// Loops that a person rejects after a run: what the .ini refuses from then on, and the state of that run
/// from which only the rest of the log has to be gone through.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/checkpoint.h"

namespace loopline {

/// The experiment with further overrides ("section.key=value").
using ExperimentLoader = std::function<Experiment(const std::vector<std::string>& overrides)>;

struct RejectedRun {
    Experiment experiment;                         ///< which refuses the loops, too
    std::shared_ptr<const Checkpoint> checkpoint;  ///< null: nothing is kept from before the first of them
};

/// `numbers`: of loops in the folder's metrics.json. Loops that were rejected in that run before stay so.
/// Throws CommandError(exit_configuration), with one sentence, if they can't be rejected: no run, another
/// configuration or log, no such loop or not an accepted one.
RejectedRun reject_loops(const std::filesystem::path& folder, const std::vector<std::uint64_t>& numbers,
                         const ExperimentLoader& load);

/// What `--resume` goes on with: the experiment, with loops refused that were rejected when the run in
/// `folder` was begun.
Experiment with_rejections_of_checkpoint(const std::filesystem::path& folder, Experiment experiment,
                                         const ExperimentLoader& load);

}  // namespace loopline
