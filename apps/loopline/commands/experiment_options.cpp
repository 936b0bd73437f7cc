#include "commands/experiment_options.h"

#include <CLI/CLI.hpp>

namespace loopline {

void declare_overlay(CLI::App& app, std::vector<std::string>& overlays) {
    app.add_option(
           "--overlay", overlays,
           "Another .ini whose keys take the place of the experiment's, as `loopline calibrate` writes "
           "one; may be repeated")
        ->type_name("FILE.ini")
        ->allow_extra_args(false);
}

void ExperimentOptions::declare(CLI::App& app) {
    app.add_option("config", config, "The experiment's .ini file")->required()->type_name("CONFIG.ini");
    app.add_option("--rawlog", rawlogs, "Log to use instead of [run] rawlog; may be repeated")
        ->type_name("FILE")
        ->allow_extra_args(false);
    declare_overlay(app, overlays);
    app.add_option("--set", overrides, "Override one key; may be repeated")
        ->type_name("SECTION.KEY=VALUE")
        ->allow_extra_args(false);
}

Experiment ExperimentOptions::load(const std::vector<std::string>& more_overrides) const {
    auto all = overrides;
    all.insert(all.end(), more_overrides.begin(), more_overrides.end());
    return load_experiment(config, all, rawlogs, overlays);
}

}  // namespace loopline
