/// A run that was killed or interrupted anywhere, and resumed, leaves the same bytes as one that was not.
#include "support/resumed_run.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

const std::string chain = "modules = odometry lines line_slam\nmaps = grid\n";
}  // namespace

TEST(Resume, a_run_may_be_broken_again_and_again) {
    const BrokenRuns runs(telecom_log, "checkpoint_items = 10\n" + chain);
    ASSERT_EQ(runs.run("whole", false), 0);
    EXPECT_EQ(runs.run("broken", false, Break::kill_worker, 60), 137);
    EXPECT_EQ(runs.run("broken", true, Break::interrupt, 61), 130);
    EXPECT_EQ(runs.run("broken", true, Break::kill_all, 62), 137);
    EXPECT_EQ(runs.run("broken", true, Break::kill_worker, 300), 137);
    EXPECT_EQ(runs.run("broken", true, Break::interrupt, 440), 130);
    EXPECT_EQ(runs.run("broken", true), 0);
    runs.expect_same("broken", "whole");
}

TEST(Resume, an_interrupted_run_has_a_checkpoint_even_if_none_was_due) {
    const BrokenRuns runs(telecom_log, "checkpoint_s = 0\n" + chain);
    ASSERT_EQ(runs.run("whole", false), 0);
    EXPECT_EQ(runs.run("broken", false, Break::interrupt, 123), 130);
    EXPECT_EQ(runs.run("broken", true), 0);
    runs.expect_same("broken", "whole");
    EXPECT_EQ(runs.run("killed", false, Break::kill_all, 123), 137);
    EXPECT_FALSE(std::filesystem::exists(runs.checkpoint("killed")));
    EXPECT_EQ(runs.run("killed", true), exit_configuration);
}

TEST(Resume, checkpoints_change_no_result) {
    const BrokenRuns often(telecom_log, "checkpoint_items = 3\n" + chain);
    const BrokenRuns never(telecom_log, "checkpoint_s = 0\n" + chain);
    ASSERT_EQ(often.run("out", false), 0);
    ASSERT_EQ(never.run("out", false), 0);
    for (const char* file : {"trajectory.tum", "covariance.csv", "map.lines.csv", "recorded.rawlog"})
        EXPECT_TRUE(file_bytes(often.path("out") + "/" + file) == file_bytes(never.path("out") + "/" + file))
            << file;
}

TEST(Resume, needs_what_the_run_had_set_aside_as_it_was) {
    const BrokenRuns runs(telecom_log, "checkpoint_items = 10\nmodules = odometry\n");
    ASSERT_EQ(runs.run("whole", false), 0);
    EXPECT_FALSE(std::filesystem::exists(runs.path("whole") + "/scratch"));
    for (const bool damaged : {true, false}) {
        EXPECT_EQ(runs.run("broken", false, Break::kill_all, 200), 137);
        const std::string file = runs.path("broken") + "/scratch/odometry";
        std::string bytes = file_bytes(file);
        ASSERT_GT(bytes.size(), 100u);
        if (damaged)
            bytes[bytes.size() / 3] ^= 1;
        else
            bytes.resize(bytes.size() / 2);
        write_file(file, bytes);
        EXPECT_EQ(runs.run("broken", true), exit_configuration);
    }
    // What came after the checkpoint does not count.
    EXPECT_EQ(runs.run("broken", false, Break::kill_all, 200), 137);
    const std::string file = runs.path("broken") + "/scratch/odometry";
    write_file(file, file_bytes(file) + std::string(5000, 'x'));
    EXPECT_EQ(runs.run("broken", true), 0);
    runs.expect_same("broken", "whole");
}

/// Refused with one sentence that says why, and nothing changes.
class RefusedResume : public ::testing::Test {
 protected:
    void SetUp() override {
        log_ = runs_folder_ / "log";
        std::filesystem::copy_file(telecom_log, log_);
        runs_ = std::make_unique<BrokenRuns>(log_, "checkpoint_items = 10\nmodules = odometry\n");
        ASSERT_EQ(runs_->run("out", false, Break::kill_all, 100), 137);
        experiment_ = load_experiment(runs_->path("run.ini"), {}, {});
    }
    std::string refusal() {
        try {
            const Checkpoint checkpoint(runs_->path("out"), experiment_);
        } catch (const CommandError& e) {
            EXPECT_EQ(e.code(), exit_configuration);
            return e.what();
        }
        return "none";
    }
    void expect_refusal(const std::string& why) {
        const std::string said = refusal();
        EXPECT_NE(said.find(why), std::string::npos) << said;
        EXPECT_NE(said.find("checkpoint.bin"), std::string::npos) << said;
        EXPECT_NE(said.find("run without --resume to start from the beginning"), std::string::npos) << said;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
    Folder runs_folder_;
    std::string log_;
    std::unique_ptr<BrokenRuns> runs_;
    Experiment experiment_;
};

TEST_F(RefusedResume, not_where_everything_is_as_it_was) {
    EXPECT_EQ(refusal(), "none");
}

TEST_F(RefusedResume, without_a_checkpoint) {
    std::filesystem::remove(runs_->checkpoint("out"));
    expect_refusal("there is no checkpoint to resume from");
}

TEST_F(RefusedResume, with_another_configuration) {
    experiment_ = load_experiment(runs_->path("run.ini"), {"odometry.max_delay_s=3"}, {});
    expect_refusal("another configuration ([odometry] max_delay_s = 2, and now 3)");
}

TEST_F(RefusedResume, with_another_log_of_the_same_length) {
    std::string bytes = file_bytes(log_);
    bytes[bytes.size() / 2] ^= 1;
    write_file(log_, bytes);
    expect_refusal("another log than what " + log_ + " holds now");
}

TEST_F(RefusedResume, with_any_damaged_or_missing_byte) {
    const std::string bytes = file_bytes(runs_->checkpoint("out"));
    for (const std::size_t at : {std::size_t{0}, std::size_t{30}, bytes.size() / 2, bytes.size() - 1}) {
        std::string damaged = bytes;
        damaged[at] ^= 0x10;
        write_file(runs_->checkpoint("out"), damaged);
        expect_refusal("this checkpoint can't be used: ");
    }
    for (const std::size_t size : {std::size_t{0}, std::size_t{25}, bytes.size() - 1}) {
        write_file(runs_->checkpoint("out"), bytes.substr(0, size));
        expect_refusal("this checkpoint can't be used: ");
    }
}
