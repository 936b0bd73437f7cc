/// What every command takes that works on an experiment: its .ini, and what replaces parts of it.
#pragma once

#include <string>
#include <vector>

#include "config/experiment.h"

namespace CLI {
class App;
}

namespace loopline {

struct ExperimentOptions {
    std::string config;
    std::vector<std::string> rawlogs, overlays, overrides;

    void declare(CLI::App& app);
    /// With further overrides after those of the command line.
    Experiment load(const std::vector<std::string>& more_overrides = {}) const;
};

/// "--overlay FILE.ini" alone.
void declare_overlay(CLI::App& app, std::vector<std::string>& overlays);

}  // namespace loopline
