#include "commands/check.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "commands/check_report.h"
#include "commands/terminal.h"
#include "pipeline/supervisor.h"

namespace loopline {
namespace {

/// Reads the logs once; in a worker process, since damaged bytes can crash MRPT's readers.
int check_logs(const Experiment& experiment, const Attempt& attempt) {
    LogSource source(experiment.run.rawlogs, attempt.rules, Mounting(experiment.mount));
    LogSurvey survey;
    for (StreamItem item; source.next(item);) {
        if (attempt.rules.state && attempt.rules.state->stop_requested) return exit_interrupted;
        survey.add(item);
    }
    const auto report = check_report(experiment, source, survey, terminal_width());
    if (!(std::cout << report.text << std::flush)) return exit_configuration;
    return report.verdict;
}

class CheckCommand : public Command {
 public:
    std::string name() const override { return "check"; }
    std::string sentence() const override { return "Checks a configuration and its data before a long run"; }

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
        const auto experiment = load_experiment(config_, overrides_, rawlogs_);
        Supervision supervision;
        supervision.rawlogs = experiment.run.rawlogs;
        return static_cast<ExitCode>(supervise(
            supervision, [&experiment](const Attempt& attempt) { return check_logs(experiment, attempt); }));
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
