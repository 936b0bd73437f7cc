/// loopline sweep CONFIG.ini --vary KEY=VALUES: one experiment with many values and on many logs, in one
/// table.
#include "commands/sweep.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "commands/experiment_options.h"
#include "output/output_file.h"
#include "sweep/child_processes.h"
#include "sweep/sweep_plan.h"
#include "sweep/sweep_table.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

/// "0007": so that names sort as numbers do.
std::string numbered(std::size_t number) {
    char text[24];
    std::snprintf(text, sizeof text, "%04zu", number);
    return text;
}

std::string text_of_file(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

class SweepCommand : public Command {
 public:
    std::string name() const override { return "sweep"; }
    std::string sentence() const override {
        return "runs an experiment with many values of its keys and on many logs, into one table";
    }

    void declare(CLI::App& app) override {
        app.add_option("config", config_, "The experiment's .ini file")->required()->type_name("CONFIG.ini");
        app.add_option("--vary", vary_,
                       "A key and the values that it takes; of several, every combination is run")
            ->type_name("SECTION.KEY=V,V,...")
            ->allow_extra_args(false);
        app.add_option("--rawlog", rawlogs_, "Log to run on instead of [run] rawlog; every one of several")
            ->type_name("FILE")
            ->allow_extra_args(false);
        app.add_option("--scenario", scenario_, "Simulate the logs from it, one for each of the seeds")
            ->type_name("SCENARIO.ini");
        app.add_option("--seeds", seeds_, "Of the scenario; without one, values of [run] seed")
            ->type_name("1-20");
        app.add_option(
               "--metric", metrics_,
               "Figure of metrics.json to tabulate, modules.lines.mean_ms for one inside others, modules_s "
               "for the time in all modules; may be repeated; errors, times and counts if it is not given")
            ->type_name("NAME")
            ->allow_extra_args(false);
        declare_overlay(app, overlays_);
        app.add_option("--set", overrides_, "Override one key in all runs; may be repeated")
            ->type_name("SECTION.KEY=VALUE")
            ->allow_extra_args(false);
        app.add_option("--jobs", jobs_, "Runs at the same time; more than one spoils their times")
            ->check(CLI::Range(1, 256));
        app.add_option("--out", folder_, "Folder for sweep.md, sweep.csv, runs.csv and the run directories")
            ->required()
            ->type_name("DIR");
        app.add_flag("--quiet", quiet_, "Say nothing but errors");
        app.footer(
            "Runs write only their figures: [outputs] are off unless a --set turns them on.\n"
            "  loopline sweep ini/sim/ring_corridor.ini --scenario datasets/ring_corridor.ini --seeds 1-5 "
            "\\\n"
            "      --vary line_slam.interval_scans=1,2,5,10,20,50,100 --out runs/interval\n\n" +
            app.get_footer());
    }

    ExitCode run() override {
        SweepTable table;
        for (const auto& text : vary_) table.variations.push_back(variation_from_text(text));
        if (!scenario_.empty() && !rawlogs_.empty())
            throw CommandError(exit_configuration, "--scenario makes the logs itself; leave --rawlog out");
        if (!scenario_.empty() && seeds_.empty()) seeds_ = "1";
        fs::create_directories(fs::path(folder_) / "runs");
        const auto logs = make_logs();
        plan_runs(logs, table);
        interrupted_ = false;
        const std::size_t count = run_children(
            commands_, static_cast<std::size_t>(jobs_),
            [&](std::size_t i, int code) { take_result(i, code, table); },
            [this] { return !wrong_configuration_; });
        if (wrong_configuration_)
            throw CommandError(exit_configuration, text_of_file(commands_[*wrong_configuration_].said));
        table.runs.resize(count);
        table.metrics = metrics_.empty() ? usual_metrics(table.runs) : metrics_;
        write(table);
        return interrupted_ ? exit_interrupted : exit_done;
    }

 private:
    /// The logs to run on, simulated where there is a scenario.
    std::vector<SweepLog> make_logs() {
        std::vector<SweepLog> logs;
        if (!scenario_.empty()) {
            const fs::path folder = fs::path(folder_) / "logs";
            fs::create_directories(folder);
            std::vector<ChildCommand> simulations;
            for (const auto seed : seeds_from_text(seeds_)) {
                const std::string name = "seed" + std::to_string(seed);
                const std::string rawlog = (folder / (name + ".rawlog")).string();
                simulations.push_back({{"simulate", scenario_, "--out", rawlog, "--quiet", "--set",
                                        "simulation.seed=" + std::to_string(seed)},
                                       folder / (name + ".txt")});
                logs.push_back({name, {"--rawlog", rawlog}});
            }
            simulate(simulations);
        } else if (!seeds_.empty()) {
            for (const auto seed : seeds_from_text(seeds_))
                logs.push_back(
                    {"seed" + std::to_string(seed), {"--set", "run.seed=" + std::to_string(seed)}});
        }
        if (!rawlogs_.empty()) {
            const auto seeded = std::move(logs);
            logs.clear();
            for (const auto& rawlog : rawlogs_) {
                const std::string name = fs::path(rawlog).filename().string();
                if (seeded.empty()) logs.push_back({name, {"--rawlog", rawlog}});
                for (SweepLog log : seeded) {
                    log.name = name + " " + log.name;
                    log.arguments.insert(log.arguments.end(), {"--rawlog", rawlog});
                    logs.push_back(log);
                }
            }
        }
        if (logs.empty()) logs.emplace_back();
        return logs;
    }

    void simulate(const std::vector<ChildCommand>& simulations) {
        std::optional<std::size_t> failed;
        int code_of_failure = 0;
        run_children(
            simulations, static_cast<std::size_t>(jobs_),
            [&](std::size_t i, int code) {
                if (code != exit_done && !failed) failed = i, code_of_failure = code;
                tell("simulated " + simulations[i].said.stem().string());
            },
            [&] { return !failed; });
        if (failed)
            throw CommandError(static_cast<ExitCode>(code_of_failure),
                               text_of_file(simulations[*failed].said));
    }

    void plan_runs(const std::vector<SweepLog>& logs, SweepTable& table) {
        for (const auto& combination : combinations_of(table.variations))
            for (const SweepLog& log : logs) {
                const fs::path out = fs::path(folder_) / "runs" / numbered(commands_.size() + 1);
                std::vector<std::string> words{"run", config_, "--out", out.string(), "--quiet"};
                for (const char* output : {"trajectory", "maps", "snapshots", "report"})
                    words.insert(words.end(), {"--set", std::string("outputs.") + output + "=false"});
                words.insert(words.end(), {"--set", "outputs.states_mb=0"});
                words.insert(words.end(), log.arguments.begin(), log.arguments.end());
                for (const auto& overlay : overlays_) words.insert(words.end(), {"--overlay", overlay});
                for (const auto& assignment : overrides_) words.insert(words.end(), {"--set", assignment});
                for (std::size_t i = 0; i < combination.size(); ++i)
                    words.insert(words.end(), {"--set", table.variations[i].key + "=" + combination[i]});
                commands_.push_back({words, out.string() + ".txt"});
                table.runs.push_back({combination, log.name, -1, {}});
            }
    }

    void take_result(std::size_t index, int exit_code, SweepTable& table) {
        SweepRun& run = table.runs[index];
        run.exit_code = exit_code;
        if (exit_code == exit_interrupted) interrupted_ = true;
        const fs::path metrics = fs::path(folder_) / "runs" / numbered(index + 1) / "metrics.json";
        std::error_code none;
        if (exit_code == exit_configuration && !wrong_configuration_) wrong_configuration_ = index;
        if (exit_code != exit_interrupted && fs::exists(metrics, none))
            run.metrics = flat_metrics(nlohmann::ordered_json::parse(text_of_file(metrics), nullptr, false));
        std::string what = std::to_string(index + 1) + " of " + std::to_string(table.runs.size());
        for (std::size_t i = 0; i < run.combination.size(); ++i)
            what += "  " + table.variations[i].key + "=" + run.combination[i];
        what += run.log.empty() ? "" : "  " + run.log;
        if (exit_code != exit_done) what += "  exit code " + std::to_string(exit_code);
        tell(what);
    }

    void write(const SweepTable& table) const {
        const fs::path folder(folder_);
        std::string command = "loopline sweep " + config_;
        for (const auto& text : vary_) command += " --vary " + text;
        for (const auto& rawlog : rawlogs_) command += " --rawlog " + rawlog;
        if (!scenario_.empty()) command += " --scenario " + scenario_;
        if (!seeds_.empty()) command += " --seeds " + seeds_;
        for (const auto& overlay : overlays_) command += " --overlay " + overlay;
        for (const auto& assignment : overrides_) command += " --set " + assignment;
        const std::string markdown = table.markdown();
        write_whole_file(folder / "sweep.md", "`" + command + "`\n\n" + markdown);
        write_whole_file(folder / "sweep.csv", table.csv());
        write_whole_file(folder / "runs.csv", table.csv_of_runs());
        if (!quiet_) std::cout << markdown << "result: " << (folder / "sweep.md").string() << std::endl;
    }

    void tell(const std::string& sentence) const {
        if (!quiet_ && isatty(2)) std::cerr << sentence << '\n';
    }

    std::string config_, folder_, scenario_, seeds_;
    std::vector<std::string> vary_, rawlogs_, metrics_, overlays_, overrides_;
    int jobs_ = 1;
    bool quiet_ = false;

    std::vector<ChildCommand> commands_;
    std::optional<std::size_t> wrong_configuration_;  ///< the run that showed it: all others would too
    bool interrupted_ = false;
};

}  // namespace

std::unique_ptr<Command> make_sweep_command() {
    return std::make_unique<SweepCommand>();
}

}  // namespace loopline
