#include "commands/check.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "config/experiment.h"

namespace loopline {
namespace {

class CheckCommand : public Command {
 public:
    std::string name() const override { return "check"; }
    std::string sentence() const override { return "Check a configuration and its data before a long run"; }
    void declare(CLI::App& app) override {
        app.add_option("config", config_, "The experiment's .ini file")->required()->type_name("CONFIG.ini");
        app.add_option("--rawlog", rawlogs_, "Log to use instead of [run] rawlog; may be repeated")
            ->type_name("FILE")
            ->allow_extra_args(false);
        app.add_option("--set", overrides_, "Override one key; may be repeated")
            ->type_name("SECTION.KEY=VALUE")
            ->allow_extra_args(false);
    }
    ExitCode run() override {
        load_experiment(config_, overrides_, rawlogs_);
        std::cout << config_ << " is right.\n";
        return exit_done;
    }

 private:
    std::string config_;
    std::vector<std::string> rawlogs_, overrides_;
};

}  // namespace

std::unique_ptr<Command> make_check_command() {
    return std::make_unique<CheckCommand>();
}

}  // namespace loopline
