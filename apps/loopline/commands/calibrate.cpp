/// loopline calibrate CONFIG.ini: what the log tells about the parameters that it is run with. A run without
/// results but those; which they are, the modules know.
#include "commands/calibrate.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>

#include "commands/experiment_options.h"
#include "config/did_you_mean.h"
#include "config/plugin_loader.h"
#include "output/calibration_ini.h"
#include "output/output_file.h"
#include "pipeline/estimate_pass.h"
#include "pipeline/log_file.h"
#include "pipeline/run.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> modules_that_calibrate() {
    std::vector<std::string> names;
    for (const auto& name : known_modules())
        if (make_module(name)->can_calibrate()) names.push_back(name);
    return names;
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const auto& word : words) text += (text.empty() ? "" : " ") + word;
    return text;
}

class CalibrateCommand : public Command {
 public:
    std::string name() const override { return "calibrate"; }
    std::string sentence() const override {
        return "estimates parameters of an experiment (slip, track width, noise) from its log, as an .ini "
               "section";
    }

    void declare(CLI::App& app) override {
        options_.declare(app);
        app.add_option("--out", out_, "File to write instead of standard output")->type_name("FILE.ini");
        app.add_flag("--quiet", quiet_, "Say nothing but warnings and errors");
        app.footer(
            "  loopline calibrate ini/sim/ring_corridor.ini --out ring.ini\n"
            "  loopline run ini/sim/ring_corridor.ini --overlay ring.ini\n\n" +
            app.get_footer());
    }

    ExitCode run() override {
        RunSetup setup;
        setup.start = std::chrono::steady_clock::now();
        setup.experiment = options_.load();
        setup.experiment.map_builders.clear();
        setup.experiment.outputs.record.clear();
        setup.calibrates = true;
        setup.quiet = quiet_;
        check(setup.experiment);
        for (const auto& rawlog : setup.experiment.run.rawlogs) LogFile can_be_opened(rawlog);
        return static_cast<ExitCode>(
            supervise(supervision_of(setup.experiment),
                      [this, &setup](const Attempt& attempt) { return calibrate(setup, attempt); }));
    }

 private:
    void check(const Experiment& experiment) const {
        const auto& modules = experiment.modules;
        if (std::none_of(modules.begin(), modules.end(), [](const auto& m) { return m->can_calibrate(); }))
            throw CommandError(exit_configuration,
                               options_.config +
                                   ": no module of [run] modules can be calibrated; those that can are " +
                                   listing(modules_that_calibrate()));
        std::error_code none;
        for (const auto& input : inputs())
            if (!out_.empty() && fs::equivalent(out_, input, none))
                throw CommandError(
                    exit_configuration,
                    "--out " + out_ + " is what the experiment is read from; give another file");
        if (!out_.empty()) OutputFile can_be_written(out_);
    }

    std::vector<std::string> inputs() const {
        std::vector<std::string> files = options_.overlays;
        files.push_back(options_.config);
        return files;
    }

    int calibrate(const RunSetup& setup, const Attempt& attempt) const {
        RunRecord record;
        estimate_pass(setup, attempt, record);
        tell_problems(record);
        const auto& calibrations = record.results.calibrations;
        if (calibrations.empty()) return record.exit_code != exit_done ? record.exit_code : exit_refused;
        const std::string text = text_of(setup.experiment, calibrations);
        if (out_.empty()) {
            std::cout << text << std::flush;
            return std::cout ? record.exit_code : exit_configuration;
        }
        write_whole_file(out_, text);
        if (!quiet_) std::cout << summary(calibrations) << "result: " << out_ << std::endl;
        return record.exit_code;
    }

    std::string text_of(const Experiment& experiment, const std::vector<Calibration>& calibrations) const {
        std::string text = "# By loopline " LOOPLINE_VERSION " from " + joined(experiment.run.rawlogs) +
                           "\n# For " + options_.config +
                           ": in place of these keys there, or with --overlay\n";
        for (const auto& module : experiment.modules)
            for (const Calibration& calibration : calibrations)
                if (module->info().name == calibration.section)
                    text += "\n" + calibration_ini_text(calibration, *module);
        return text;
    }

    static std::string summary(const std::vector<Calibration>& calibrations) {
        std::size_t told = 0, left_out = 0;
        for (const auto& calibration : calibrations)
            for (const auto& key : calibration.keys) ++(key.value ? told : left_out);
        return std::to_string(told) + " keys, " + std::to_string(left_out) + " left out\n";
    }

    ExperimentOptions options_;
    std::string out_;
    bool quiet_ = false;
};

}  // namespace

std::unique_ptr<Command> make_calibrate_command() {
    return std::make_unique<CalibrateCommand>();
}

}  // namespace loopline
