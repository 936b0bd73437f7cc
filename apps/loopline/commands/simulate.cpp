/// loopline simulate SCENARIO.ini --out F.rawlog: a simulated log, with the truth beside it. The simulator is
/// a class of the plugins; its sections are the scenario's.
#include "commands/simulate.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>

#include "api/trajectory.h"
#include "commands/interruption.h"
#include "config/plugin_loader.h"
#include "config/scenario.h"
#include "output/output_file.h"
#include "output/rawlog_file.h"
#include "output/tum.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

volatile std::sig_atomic_t interrupted = 0;
Interruption interruption;

/// While a log is made, SIGINT and SIGTERM end it without leaving half a file; a second one ends it at once.
class InterruptGuard {
 public:
    InterruptGuard() {
        for (const int signal : {SIGINT, SIGTERM})
            std::signal(signal, [](int received) {
                interrupted = 1;
                if (interruption.received() == Interruption::Wish::stop) return;
                std::signal(received, SIG_DFL);
                std::raise(received);
            });
    }
    ~InterruptGuard() {
        for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
    }
};

/// FILE.truth.tum for FILE.rawlog.
fs::path beside(fs::path rawlog, const std::string& extension) {
    return rawlog.replace_extension(extension);
}

class Files : public SimulationSink {
 public:
    Files(const fs::path& rawlog, bool quiet)
        : rawlog_(rawlog), truth_csv_(beside(rawlog, ".truth.csv")), shows_progress_(!quiet && isatty(2)) {
        truth_csv_.text("kind,number,x_m,y_m,x2_m,y2_m,bottom_m,top_m\n");
    }

    void observation(const mrpt::obs::CObservation& observation) override {
        if (interrupted) throw CommandError(exit_interrupted, "interrupted; nothing was written");
        rawlog_.write(observation);
        ++counts_[observation.sensorLabel];
    }
    void true_pose(StampNs stamp_ns, const Pose3& T_map_base) override {
        path_.append(path_.size(), stamp_ns, T_map_base, Matrix6d::Zero());
    }
    void truth(const TruthRow& row) override {
        truth_csv_.text(row.kind).text(",").integer(row.number);
        for (const double value : row.values) truth_csv_.text(",").number(value);
        truth_csv_.text("\n");
    }
    void progress(double done_s, double total_s) override {
        if (!shows_progress_) return;
        std::fprintf(stderr, "\rsimulating %5.1f %%", 100 * done_s / total_s);
        std::fflush(stderr);
    }
    void note(const std::string& sentence) override { notes_.push_back(sentence); }

    void commit(const fs::path& rawlog, const std::string& effective_scenario) {
        if (shows_progress_) std::fputs("\r\033[K", stderr);
        truth_csv_.commit();
        write_tum(beside(rawlog, ".truth.tum"), path_, Estimate::latest);
        write_whole_file(beside(rawlog, ".scenario.ini"), effective_scenario);
        rawlog_.commit();
    }

    std::string summary() const {
        std::string text;
        for (const auto& [label, count] : counts_)
            text += (text.empty() ? "" : ", ") + std::to_string(count) + " of " + label;
        text += '\n';
        for (const auto& sentence : notes_) text += sentence + '\n';
        return text;
    }

 private:
    RawlogFile rawlog_;
    OutputFile truth_csv_;
    Trajectory path_;
    std::map<std::string, std::size_t> counts_;
    std::vector<std::string> notes_;
    bool shows_progress_;
};

class SimulateCommand : public Command {
 public:
    std::string name() const override { return "simulate"; }
    std::string sentence() const override { return "Makes a log and its truth from a scenario"; }

    void declare(CLI::App& app) override {
        app.add_option("scenario", scenario_, "The scenario: an .ini file, as in datasets/")
            ->required()
            ->type_name("SCENARIO.ini");
        app.add_option("--out", out_, "The rawlog to write; the truth goes to F.truth.tum and F.truth.csv")
            ->required()
            ->type_name("F.rawlog");
        app.add_option("--set", overrides_, "Replaces a value of the scenario, as in simulation.seed=2")
            ->type_name("section.key=value")
            ->allow_extra_args(false);
        app.add_flag("--quiet", quiet_, "Say nothing but errors");
    }

    ExitCode run() override {
        load_plugins();
        const auto simulators = known_simulators();
        if (simulators.empty())
            throw CommandError(exit_configuration, "no plugin can simulate; install Loopline again");
        const Simulator::Ptr simulator = make_simulator(simulators.front());
        const std::string effective = load_scenario(scenario_, overrides_, *simulator);
        std::error_code ignored;
        if (fs::equivalent(scenario_, out_, ignored))
            throw CommandError(exit_configuration, "--out " + out_ + " is the scenario; give another file");
        const InterruptGuard guard;
        Files files(out_, quiet_);
        try {
            simulator->simulate(files);
        } catch (const CommandError&) {
            throw;
        } catch (const std::runtime_error& e) {
            throw CommandError(exit_configuration, scenario_ + ": " + e.what());
        }
        files.commit(out_, effective);
        if (!quiet_) std::cout << out_ << ": " << files.summary();
        return exit_done;
    }

 private:
    std::string scenario_, out_;
    std::vector<std::string> overrides_;
    bool quiet_ = false;
};

}  // namespace

std::unique_ptr<Command> make_simulate_command() {
    return std::make_unique<SimulateCommand>();
}

}  // namespace loopline
