/// A loop that is rejected after a run leaves the same bytes as a run whose .ini refuses it, and only what
/// comes after it is done again.
#include <algorithm>

#include "pipeline/kept_states.h"
#include "pipeline/loop_rejection.h"
#include "support/resumed_run.h"
#include "support/ring_log.h"

using namespace loopline;
using namespace loopline::testing;

namespace rejections {

/// The first module of a chain; leaves a note on the first item that it sees.
class FirstItem : public Module {
 public:
    FirstItem() = default;
    explicit FirstItem(std::string note) : note_(std::move(note)) {}
    ModuleInfo info() const override { return {"first_item", "", {}, {}, {}}; }
    ParameterTable parameters() override { return {"first_item", ""}; }
    bool can_resume() const override { return true; }
    void process(const StreamItem& item, Publisher&) override {
        if (!note_.empty()) write_file(note_, std::to_string(item.sequence));
        note_.clear();
    }
    mrpt::rtti::CObject* clone() const override { return new FirstItem(*this); }

 private:
    std::string note_;
};

/// How a run begins and ends.
struct How {
    std::vector<std::uint64_t> rejected;
    bool resume = false;
    Break kind = Break::none;
    std::uint64_t at = 0;
    std::vector<std::string> overrides;
};

/// A map that is soon too uncertain to match with, so that the way around makes a loop.
const std::string soon_uncertain = "active_sigma_m = 0.08\n";

class RingRuns {
 public:
    explicit RingRuns(const std::string& keys = soon_uncertain, std::string log = test::ring_log())
        : ini_(folder_ / "ring.ini"), log_(std::move(log)) {
        write_file(ini_, "[run]\nrawlog = " + log_ +
                             "\nmodules = odometry grid_slam\nmaps = grid\ncheckpoint_items = 100\n"
                             "[outputs]\nrecord = odometry_at_scan grid_slam\nsnapshots = false\n"
                             "report = false\n[grid_slam]\n" +
                             keys);
    }

    /// Exit code, or 128 + signal; `said` is what a CommandError says.
    int run(const std::string& out, const How& how = {}) const {
        const pid_t child = ::fork();
        if (child == 0) ::_exit(run_here(out, how));
        int status = 0;
        ::waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    std::string path(const std::string& out) const { return folder_ / out; }
    std::string said() const { return file_bytes(folder_ / "said"); }
    std::uint64_t first_item() const { return std::stoull(file_bytes(folder_ / "first")); }
    const std::string& log() const { return log_; }

    nlohmann::json loops(const std::string& out) const {
        return nlohmann::json::parse(file_bytes(path(out) + "/metrics.json"))["loops"];
    }
    /// Numbers of the accepted ones.
    std::vector<std::uint64_t> accepted(const std::string& out) const {
        std::vector<std::uint64_t> numbers;
        for (const auto& loop : loops(out))
            if (loop["decision"] == "accepted") numbers.push_back(loop["number"]);
        return numbers;
    }
    std::string name(const std::string& out, std::uint64_t number) const {
        return loops(out)[number - 1]["loop"];
    }
    std::vector<std::string> files(const std::string& out) const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(path(out)))
            if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(path(out)).string());
        std::sort(names.begin(), names.end());
        return names;
    }
    /// Byte by byte, but for times in metrics.json and in the states.
    void expect_same(const std::string& out, const std::string& whole) const {
        EXPECT_EQ(files(out), files(whole));
        for (const auto& name : files(whole)) {
            const std::string a = file_bytes(path(out) + "/" + name),
                              b = file_bytes(path(whole) + "/" + name);
            if (name == "metrics.json") {
                EXPECT_EQ(BrokenRuns::lasting(a), BrokenRuns::lasting(b));
            } else if (name.rfind("states/", 0) != 0) {
                EXPECT_TRUE(a == b) << name;
            }
        }
    }
    static How refusing(const std::string& loops) {
        How how;
        how.overrides = {"grid_slam.refuse_loops=" + loops};
        return how;
    }

 private:
    int run_here(const std::string& out, const How& how) const {
        try {
            const ExperimentLoader load = [&](const std::vector<std::string>& more) {
                auto all = how.overrides;
                all.insert(all.end(), more.begin(), more.end());
                return load_experiment(ini_, all, {});
            };
            RunSetup setup;
            setup.start = std::chrono::steady_clock::now();
            setup.folder = path(out);
            setup.quiet = true;
            if (!how.rejected.empty()) {
                RejectedRun run = reject_loops(setup.folder, how.rejected, load);
                setup.experiment = std::move(run.experiment);
                setup.checkpoint = std::move(run.checkpoint);
            } else {
                setup.experiment = load({});
            }
            if (how.resume) {
                setup.experiment =
                    with_rejections_of_checkpoint(setup.folder, std::move(setup.experiment), load);
                setup.checkpoint = std::make_shared<const Checkpoint>(setup.folder, setup.experiment);
            }
            auto& modules = setup.experiment.modules;
            modules.insert(modules.begin(), std::make_shared<FirstItem>(folder_ / "first"));
            modules.push_back(std::make_shared<Breaker>(how.kind, how.at));
            Supervision supervision;
            supervision.rawlogs = setup.experiment.run.rawlogs;
            return supervise(supervision,
                             [&setup](const Attempt& attempt) { return run_experiment(setup, attempt); });
        } catch (const CommandError& e) {
            write_file(folder_ / "said", e.what());
            return e.code();
        } catch (const std::exception& e) {
            write_file(folder_ / "said", e.what());
            return 99;
        }
    }

    Folder folder_;
    std::string ini_, log_;
};

TEST(RejectedLoop, leaves_the_bytes_of_a_run_whose_ini_refuses_it) {
    for (const char* weights : {"joint", "covariance"}) {
        const RingRuns runs(soon_uncertain + "weights = " + std::string(weights) + "\n");
        ASSERT_EQ(runs.run("out"), 0) << runs.said();
        const auto loops = runs.accepted("out");
        ASSERT_FALSE(loops.empty());
        const std::string state = kept_state_name(loops[0]), name = runs.name("out", loops[0]);
        EXPECT_TRUE(std::filesystem::exists(runs.path("out") + "/" + state));
        ASSERT_EQ(runs.run("whole", RingRuns::refusing(name)), 0);
        EXPECT_EQ(runs.first_item(), 0u);

        How reject;
        reject.rejected = {loops[0]};
        ASSERT_EQ(runs.run("out", reject), 0) << runs.said();
        EXPECT_GT(runs.first_item(), 1000u) << "of 2511 items, those up to the loop were not done again";
        runs.expect_same("out", "whole");
        EXPECT_EQ(runs.loops("out")[loops[0] - 1]["reason"], "refused by the .ini");
        EXPECT_FALSE(std::filesystem::exists(runs.path("out") + "/" + state));
    }
}

TEST(RejectedLoop, another_one_may_be_rejected_after_it_and_before_it) {
    // Too uncertain even sooner: then more loops are found.
    const RingRuns runs("active_sigma_m = 0.02\n");
    ASSERT_EQ(runs.run("out"), 0) << runs.said();
    std::filesystem::copy(runs.path("out"), runs.path("backward"), std::filesystem::copy_options::recursive);
    const auto loops = runs.accepted("out");
    ASSERT_GE(loops.size(), 2u);
    How first, second;
    first.rejected = {loops[0]};
    ASSERT_EQ(runs.run("out", first), 0) << runs.said();
    const auto left = runs.accepted("out");
    ASSERT_FALSE(left.empty());
    const std::string names = runs.name("backward", loops[0]) + ", " + runs.name("out", left.back());
    second.rejected = {left.back()};
    ASSERT_EQ(runs.run("out", second), 0) << runs.said();
    ASSERT_EQ(runs.run("whole", RingRuns::refusing(names)), 0);
    runs.expect_same("out", "whole");

    // The last one first; then the state before the first is still of use.
    const std::string backward = runs.name("backward", loops.back()) + ", " + runs.name("backward", loops[0]);
    How last;
    last.rejected = {loops.back()};
    ASSERT_EQ(runs.run("backward", last), 0) << runs.said();
    ASSERT_EQ(runs.run("backward", first), 0) << runs.said();
    EXPECT_GT(runs.first_item(), 150u) << "the first is closed soon after the beginning";
    ASSERT_EQ(runs.run("whole_backward", RingRuns::refusing(backward)), 0);
    runs.expect_same("backward", "whole_backward");
}

TEST(RejectedLoop, goes_on_after_a_kill) {
    const RingRuns runs;
    ASSERT_EQ(runs.run("out"), 0);
    const auto number = runs.accepted("out").at(0);
    ASSERT_EQ(runs.run("whole", RingRuns::refusing(runs.name("out", number))), 0);
    How reject, killed, resume;
    reject.rejected = killed.rejected = {number};
    killed.kind = Break::kill_all;
    resume.resume = true;
    for (const bool soon : {true, false}) {  // before and after its first regular checkpoint
        const std::string out = soon ? "soon" : "late";
        std::filesystem::copy(runs.path("out"), runs.path(out), std::filesystem::copy_options::recursive);
        killed.at = soon ? 0 : 2200;
        EXPECT_EQ(runs.run(out, killed), 137);
        EXPECT_EQ(runs.accepted(out).at(0), number) << "the results are still those of the first run";
        ASSERT_EQ(runs.run(out, resume), 0) << runs.said();
        EXPECT_GT(runs.first_item(), soon ? 1000u : 2000u);
        runs.expect_same(out, "whole");
    }
    EXPECT_EQ(runs.run("out", killed), 137);
    ASSERT_EQ(runs.run("out", reject), 0) << "the same command again serves as well";
    runs.expect_same("out", "whole");
}

TEST(RejectedLoop, what_was_rejected_in_a_run_that_was_interrupted_stays_so) {
    const RingRuns runs;
    How interrupted, reject;
    interrupted.kind = Break::interrupt;
    interrupted.at = 1500;
    ASSERT_EQ(runs.run("out", interrupted), 130);
    reject.rejected = {runs.accepted("out").at(0)};
    ASSERT_EQ(runs.run("whole", RingRuns::refusing(runs.name("out", reject.rejected[0]))), 0);
    ASSERT_EQ(runs.run("out", reject), 0) << runs.said();
    runs.expect_same("out", "whole");
}

TEST(RejectedLoop, without_a_state_the_run_starts_over) {
    const RingRuns runs;
    How without;
    without.overrides = {"outputs.states_mb=0"};
    ASSERT_EQ(runs.run("out", without), 0);
    EXPECT_FALSE(std::filesystem::exists(runs.path("out") + "/states"));
    How refusing = RingRuns::refusing(runs.name("out", runs.accepted("out").at(0)));
    refusing.overrides.push_back("outputs.states_mb=0");
    ASSERT_EQ(runs.run("whole", refusing), 0);
    without.rejected = runs.accepted("out");
    ASSERT_EQ(runs.run("out", without), 0) << runs.said();
    EXPECT_EQ(runs.first_item(), 0u);
    runs.expect_same("out", "whole");

    // So it does where the state is damaged.
    ASSERT_EQ(runs.run("damaged"), 0);
    const auto number = runs.accepted("damaged").at(0);
    const std::string state = runs.path("damaged") + "/" + kept_state_name(number);
    std::filesystem::resize_file(state, std::filesystem::file_size(state) / 2);
    How reject;
    reject.rejected = {number};
    ASSERT_EQ(runs.run("damaged", reject), 0);
    EXPECT_EQ(runs.first_item(), 0u);
}

TEST(RejectedLoop, a_later_run_leaves_no_states_of_an_earlier_one) {
    const RingRuns runs;
    ASSERT_EQ(runs.run("out"), 0);
    write_file(runs.path("out") + "/states/loop_99.bin", "of a run that was killed");
    write_file(runs.path("out") + "/states/notes.txt", "of somebody else");
    How off;
    off.overrides = {"grid_slam.loops=no"};
    ASSERT_EQ(runs.run("out", off), 0);
    std::vector<std::string> states;
    for (const auto& file : runs.files("out"))
        if (file.rfind("states/", 0) == 0) states.push_back(file);
    EXPECT_EQ(states, std::vector<std::string>{"states/notes.txt"});
}

TEST(RejectedLoop, what_can_not_be_rejected_is_told_in_one_sentence) {
    Folder folder;
    const std::string log = folder / "ring.rawlog";
    std::filesystem::copy_file(test::ring_log(), log);
    const RingRuns runs(soon_uncertain, log);
    const auto refusal = [&runs](std::uint64_t number, const std::vector<std::string>& overrides = {}) {
        How how;
        how.rejected = {number};
        how.overrides = overrides;
        EXPECT_EQ(runs.run("out", how), exit_configuration);
        EXPECT_EQ(runs.said().find('\n'), std::string::npos);
        return runs.said();
    };
    EXPECT_EQ(refusal(1), "--reject-loop: there is no run in " + runs.path("out") +
                              " whose loops could be rejected; run it first without --reject-loop");
    ASSERT_EQ(runs.run("out"), 0);
    const auto loops = runs.loops("out");
    EXPECT_EQ(refusal(loops.size() + 1),
              "--reject-loop: there is no loop " + std::to_string(loops.size() + 1) + ": " +
                  runs.path("out") + "/metrics.json lists numbers 1 to " + std::to_string(loops.size()));
    EXPECT_EQ(refusal(0).find("--reject-loop: there is no loop 0: "), 0u);
    EXPECT_EQ(refusal(1), "--reject-loop: loop 1 of " + runs.path("out") +
                              "/metrics.json is not an accepted one (" +
                              loops[0]["reason"].get<std::string>() + "), so there is nothing to reject");
    const auto number = runs.accepted("out").at(0);
    EXPECT_EQ(
        refusal(number, {"grid_slam.cell_m=0.1"}),
        "--reject-loop: the run in " + runs.path("out") +
            " was made with another configuration ([grid_slam] cell_m = 0.05, and now 0.1); run without "
            "--reject-loop to start from the beginning");
    EXPECT_NE(refusal(number, {"grid_slam.refuse_loops=5"}).find("[grid_slam] refuse_loops = , and now 5"),
              std::string::npos);
    EXPECT_EQ(refusal(number, {"run.modules=odometry", "run.trajectory=odometry"}),
              "--reject-loop: no module of [run] modules closes loops");
    std::string bytes = file_bytes(log);
    bytes[bytes.size() / 2] ^= 1;
    write_file(log, bytes);
    EXPECT_EQ(refusal(number), "--reject-loop: the run in " + runs.path("out") +
                                   " was made with another log than what " + log +
                                   " holds now; run without --reject-loop to start from the beginning");
}

TEST(KeptStates, those_that_save_least_go_first) {
    Folder folder;
    std::filesystem::create_directories(folder / "states");
    std::vector<KeptState> states{{2, 100, 10}, {5, 500, 10}, {6, 510, 10}, {9, 900, 10}};
    for (const auto& state : states) write_file(folder / kept_state_name(state.loop), "0123456789");
    const auto numbers = [&states] {
        std::vector<std::uint64_t> loops;
        for (const auto& state : states) loops.push_back(state.loop);
        return loops;
    };
    const std::filesystem::path& path = folder.path();
    thin_kept_states(path, 40, states);
    EXPECT_EQ(numbers(), (std::vector<std::uint64_t>{2, 5, 6, 9}));
    thin_kept_states(path, 39, states);
    EXPECT_EQ(numbers(), (std::vector<std::uint64_t>{2, 5, 9}));
    EXPECT_FALSE(std::filesystem::exists(folder / "states/loop_6.bin"));
    thin_kept_states(path, 20, states);
    EXPECT_EQ(numbers(), (std::vector<std::uint64_t>{5, 9}));
    thin_kept_states(path, 9, states);
    EXPECT_TRUE(states.empty());
    EXPECT_TRUE(std::filesystem::is_empty(folder / "states"));
}

}  // namespace rejections
