#include "commands/check.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "commands/check_report.h"
#include "commands/experiment_options.h"
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

    void declare(CLI::App& app) override { options_.declare(app); }

    ExitCode run() override {
        const auto experiment = options_.load();
        Supervision supervision;
        supervision.rawlogs = experiment.run.rawlogs;
        return static_cast<ExitCode>(supervise(
            supervision, [&experiment](const Attempt& attempt) { return check_logs(experiment, attempt); }));
    }

 private:
    ExperimentOptions options_;
};

}  // namespace

std::unique_ptr<Command> make_check_command() {
    return std::make_unique<CheckCommand>();
}

}  // namespace loopline
