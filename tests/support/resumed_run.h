/// Runs of the whole pipeline that are broken off at a chosen item of the log, and taken up again.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "commands/command.h"
#include "pipeline/checkpoint.h"
#include "pipeline/run.h"
#include "pipeline/run_scratch.h"
#include "pipeline_logs.h"

namespace loopline::testing {

enum class Break { none, kill_worker, kill_all, interrupt };

/// The last module of a chain; at one item it breaks the run off.
class Breaker : public Module {
 public:
    Breaker() = default;
    Breaker(Break kind, std::uint64_t at) : kind_(kind), at_(at) {}
    ModuleInfo info() const override { return {"breaker", "", {}, {}, {}}; }
    ParameterTable parameters() override { return {"breaker", ""}; }
    bool can_resume() const override { return true; }
    void process(const StreamItem& item, Publisher&) override {
        if (kind_ == Break::none || item.sequence < at_) return;
        if (kind_ == Break::kill_all) ::kill(::getppid(), SIGKILL);
        if (kind_ != Break::interrupt) ::kill(::getpid(), SIGKILL);
        ::raise(SIGINT);
    }
    mrpt::rtti::CObject* clone() const override { return new Breaker(*this); }

 private:
    Break kind_ = Break::none;
    std::uint64_t at_ = 0;
};

/// One experiment, run as often as need be, each time in a process of its own.
class BrokenRuns {
 public:
    /// The keys of `ini` beside rawlog and outputs.
    BrokenRuns(const std::string& log, const std::string& ini) : ini_(folder_ / "run.ini") {
        write_file(ini_, "[run]\nrawlog = " + log + "\n" + ini +
                             "\n[outputs]\nrecord = lines odometry_at_scan line_slam lidar_odometry lidar_odometry_motion lidar_mapping\nsnapshots = false\n"
                             "report = false\n");
    }

    /// Exit code, or 128 + signal.
    int run(const std::string& out, bool resume, Break kind = Break::none, std::uint64_t at = 0) const {
        const pid_t child = ::fork();
        if (child == 0) ::_exit(run_here(out, resume, kind, at));
        int status = 0;
        ::waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }

    std::string path(const std::string& out) const { return folder_ / out; }
    std::string checkpoint(const std::string& out) const { return folder_ / (out + "/checkpoint.bin"); }

    /// Every file of both folders, byte by byte; of metrics.json all but times and memory, and not the states
    /// kept before loops, which hold such times too.
    void expect_same(const std::string& out, const std::string& whole) const {
        EXPECT_EQ(names(out), names(whole));
        for (const auto& name : names(whole)) {
            const std::string a = file_bytes(path(out) + "/" + name),
                              b = file_bytes(path(whole) + "/" + name);
            if (name == "metrics.json") {
                EXPECT_EQ(lasting(a), lasting(b));
            } else if (name.rfind("states/", 0) != 0) {
                EXPECT_TRUE(a == b) << name;
            }
        }
    }

    /// metrics.json without times and memory.
    static std::string lasting(const std::string& metrics) {
        auto json = nlohmann::json::parse(metrics);
        for (const char* key : {"wall_s", "cpu_s", "real_time_factor", "peak_memory_mb"}) json.erase(key);
        for (auto& module : json["modules"])
            for (const char* key : {"mean_ms", "worst_ms", "finish_ms"}) module.erase(key);
        return json.dump(2);
    }

 private:
    int run_here(const std::string& out, bool resume, Break kind, std::uint64_t at) const {
        try {
            RunSetup setup;
            setup.start = std::chrono::steady_clock::now();
            setup.experiment = load_experiment(ini_, {}, {});
            setup.experiment.modules.push_back(std::make_shared<Breaker>(kind, at));
            setup.folder = path(out);
            setup.quiet = true;
            if (resume) setup.checkpoint = std::make_shared<const Checkpoint>(setup.folder, setup.experiment);
            Supervision supervision;
            supervision.rawlogs = setup.experiment.run.rawlogs;
            return supervise(supervision, [&setup](const Attempt& attempt) {
                RunScratch scratch(setup.folder);
                setup.scratch = &scratch;
                return run_experiment(setup, attempt);
            });
        } catch (const CommandError& e) {
            return e.code();
        } catch (const std::exception&) {
            return 99;
        }
    }
    std::vector<std::string> names(const std::string& out) const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(path(out)))
            if (entry.is_regular_file())
                names.push_back(std::filesystem::relative(entry.path(), path(out)).string());
        std::sort(names.begin(), names.end());
        return names;
    }

    Folder folder_;
    std::string ini_;
};

/// Killed and interrupted early, midway and late; then taken up again.
inline void expect_same_after_breaks(const std::string& ini, const std::string& log = telecom_log,
                                     std::uint64_t last_item = 448) {
    const BrokenRuns runs(log, ini);
    ASSERT_EQ(runs.run("whole", false), 0);
    EXPECT_FALSE(std::filesystem::exists(runs.checkpoint("whole")));
    for (const Break kind : {Break::kill_worker, Break::kill_all, Break::interrupt})
        for (const double part : {0.1, 0.5, 0.93}) {
            const auto at = static_cast<std::uint64_t>(part * double(last_item));
            SCOPED_TRACE("broken off at item " + std::to_string(at));
            const int code = runs.run("broken", false, kind, at);
            EXPECT_EQ(code, kind == Break::interrupt ? 130 : 137);
            EXPECT_TRUE(std::filesystem::exists(runs.checkpoint("broken")));
            EXPECT_EQ(runs.run("broken", true), 0);
            runs.expect_same("broken", "whole");
            std::filesystem::remove_all(runs.path("broken"));
        }
}

}  // namespace loopline::testing
