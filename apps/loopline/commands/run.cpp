#include "commands/run.h"

#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>

#include "commands/experiment_options.h"
#include "pipeline/checkpoint.h"
#include "pipeline/large_pages.h"
#include "pipeline/log_file.h"
#include "pipeline/loop_rejection.h"
#include "pipeline/run.h"
#include "pipeline/run_scratch.h"
#include "pipeline/supervisor.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

/// Whether the run directory can be made is known before a long run, not after it.
void check_folder(const fs::path& folder) {
    std::error_code ignored;
    fs::path existing = fs::absolute(folder);
    while (!fs::exists(existing, ignored) && existing.has_parent_path()) existing = existing.parent_path();
    if (!fs::is_directory(existing, ignored))
        throw CommandError(exit_configuration, "--out " + folder.string() + ": " + existing.string() +
                                                   " is a file; name a folder");
    if (::access(existing.c_str(), W_OK | X_OK) != 0)
        throw CommandError(exit_configuration, "--out " + folder.string() + ": you may not write into " +
                                                   existing.string() + "; name another folder");
}

bool is_rawlog(const Experiment& experiment, const std::string& file) {
    const auto& rawlogs = experiment.run.rawlogs;
    return std::find(rawlogs.begin(), rawlogs.end(), file) != rawlogs.end();
}

/// A run replaces what an earlier one left in its folder, so that must not be what this one works with.
void check_inputs_are_elsewhere(const Experiment& experiment, const fs::path& folder) {
    std::error_code ignored;
    for (const auto& file : input_paths(experiment))
        if (fs::equivalent(fs::path(file).parent_path(), folder, ignored) && !is_rawlog(experiment, file))
            throw CommandError(exit_configuration, "--out " + folder.string() + ": this run reads " + file +
                                                       ", which it would replace; name another folder");
}

void set_cost_so_far(RunSetup& setup) {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    const auto seconds = [](const timeval& time) {
        return double(time.tv_sec) + 1e-6 * double(time.tv_usec);
    };
    setup.cpu_before_s = seconds(used.ru_utime) + seconds(used.ru_stime);
    setup.peak_before_mb = static_cast<double>(used.ru_maxrss) / 1024;
}

class RunCommand : public Command {
 public:
    std::string name() const override { return "run"; }
    std::string sentence() const override {
        return "runs an experiment: from a rawlog to a trajectory, a map and pictures";
    }

    void declare(CLI::App& app) override {
        options_.declare(app);
        app.add_option("--out", folder_, "The run directory; runs/NAME for NAME.ini if it is not given")
            ->type_name("DIR");
        app.add_option("--threads", threads_, "At most so many; the result does not depend on it")
            ->check(CLI::Range(1, 1024));
        auto* resume = app.add_flag("--resume", resume_, "Go on from the checkpoint in the run directory");
        app.add_option("--reject-loop", rejected_,
                       "Loop N of the run directory's metrics.json is none: run again from before it; may be "
                       "repeated")
            ->type_name("N")
            ->allow_extra_args(false)
            ->excludes(resume);
        app.add_flag("--quiet", quiet_, "Say nothing but warnings and errors");
    }

    ExitCode run() override {
        RunSetup setup;
        setup.start = std::chrono::steady_clock::now();
        setup.folder =
            folder_.empty() ? fs::path("runs") / fs::path(options_.config).stem() : fs::path(folder_);
        take_up(setup);
        setup.threads = threads_;
        setup.quiet = quiet_;
        for (const auto& rawlog : setup.experiment.run.rawlogs) LogFile can_be_opened(rawlog);
        check_folder(setup.folder);
        check_inputs_are_elsewhere(setup.experiment, setup.folder);
        set_cost_so_far(setup);

        return static_cast<ExitCode>(
            supervise(supervision_of(setup.experiment), [&setup](const Attempt& attempt) {
                use_large_pages();
                RunScratch scratch(setup.folder);
                setup.scratch = &scratch;
                setup.reference = load_evaluation_reference(setup.experiment.evaluation, scratch.folder());
                return run_experiment(setup, attempt);
            }));
    }

 private:
    /// What to run, and from where on.
    void take_up(RunSetup& setup) const {
        const ExperimentLoader load = [this](const std::vector<std::string>& overrides) {
            return options_.load(overrides);
        };
        if (rejected_.empty()) {
            setup.experiment = options_.load();
            if (!resume_) return;
            setup.experiment = with_rejections_of_checkpoint(setup.folder, std::move(setup.experiment), load);
            setup.checkpoint = std::make_shared<const Checkpoint>(setup.folder, setup.experiment);
            return;
        }
        RejectedRun run = reject_loops(setup.folder, rejected_, load);
        setup.experiment = std::move(run.experiment);
        setup.checkpoint = std::move(run.checkpoint);
        if (setup.checkpoint) return;
        remove_checkpoint(setup.folder);  // of a run without the rejection
        if (!quiet_)
            std::cerr << "loopline: no state is kept from before loop "
                      << *std::min_element(rejected_.begin(), rejected_.end())
                      << ", so the run starts from the beginning\n";
    }

    ExperimentOptions options_;
    std::string folder_;
    int threads_ = 1;
    bool quiet_ = false, resume_ = false;
    std::vector<std::uint64_t> rejected_;
};

}  // namespace

std::unique_ptr<Command> make_run_command() {
    return std::make_unique<RunCommand>();
}

}  // namespace loopline
