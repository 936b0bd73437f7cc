/// metrics.json: the figures of a run under flat keys, its loops, and the time of every module.
#pragma once

#include <nlohmann/json.hpp>

#include "pipeline/run_record.h"

namespace loopline {

/// Keys that don't apply to the run, and figures that are not finite numbers, are absent. What the host knows
/// comes first and can't be replaced by a module; then the modules' own figures by name; then `loops`, if any
/// was looked at, with stamps since the first one of the log; then `modules`.
nlohmann::ordered_json metrics_json(const RunRecord& record);

}  // namespace loopline
