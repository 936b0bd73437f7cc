/// Damaged logs can crash MRPT's readers, which nothing inside the process survives. So the work is done in a
/// forked worker, and this process only waits for it: if the worker dies or hangs while it reads an object,
/// another one starts over and stops before that object. What a worker does is the same each time, so nothing
/// has to be handed over.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "pipeline/read_guard.h"
#include "pipeline/worker_state.h"

namespace loopline {

/// What a worker is told, beside its work.
struct Attempt {
    ReadingRules rules;  ///< with the shared state; pass them to LogSource
    /// An earlier worker failed outside of reading, at this item: stop before it, finish, and save what there
    /// is.
    std::optional<std::uint64_t> stop_before_sequence;
    /// An earlier worker failed while drawing maps: do without them.
    bool without_maps = false;
    /// One sentence on that failure.
    std::string failure;
    /// No earlier worker found damage or failed.
    bool first() const {
        return failure.empty() && std::none_of(rules.limits.begin(), rules.limits.end(),
                                               [](const auto& limit) { return limit.has_value(); });
    }
};

struct Supervision {
    std::vector<std::string> rawlogs;
    std::vector<std::string> module_names;  ///< for the sentences; by WorkerState::index
    std::vector<std::string> map_builder_names;
    /// An object that is read for longer than this is damaged. Time in which everything was stopped does not
    /// count.
    std::chrono::milliseconds longest_read{20'000};
};

Supervision supervision_of(const Experiment& experiment);

/// Runs `work` in a worker process and returns its exit code. SIGINT and SIGTERM set the state's
/// stop_requested, a second wish (interruption.h) ends the worker at once (exit code 130). Exceptions that leave `work`: a
/// CommandError is printed, its code returned; any other is a failure of the stage that the state tells. If
/// the worker can't be brought to its end, one sentence on stderr says why, and the exit code is 4, or 137 if
/// it was killed from outside.
int supervise(const Supervision& supervision, const std::function<int(const Attempt&)>& work);

}  // namespace loopline
