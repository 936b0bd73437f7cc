/// What the time of a module is told per. A module sees every item of the log and passes over most of them;
/// its calls in metrics.json count those of its main input, so that mean_ms is its time per scan, not per
/// item.
#pragma once

#include <cstring>
#include <string>

#include "api/module.h"
#include "pipeline/log_facts.h"

namespace loopline {

class MainInput {
 public:
    /// The first class that the module needs, else the first that it uses; a module that names none takes
    /// all.
    explicit MainInput(const ModuleInfo& info) {
        const auto& classes = info.needs.empty() ? info.uses : info.needs;
        if (!classes.empty()) class_ = short_class_name(classes.front());
    }

    bool holds(const mrpt::obs::CObservation& observation) const {
        if (class_.empty()) return true;
        const char* name = observation.GetRuntimeClass()->className;
        const char* colon = std::strrchr(name, ':');
        return class_ == (colon != nullptr ? colon + 1 : name);
    }

 private:
    std::string class_;  ///< without its namespace; empty: any
};

}  // namespace loopline
