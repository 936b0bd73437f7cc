/// SIGINT, SIGTERM and SIGKILL in the middle of a run.
#include <fcntl.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "cli/run_support.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

/// A run of many seconds that records what it sees, so that a file appears when it is under way.
class LongRun {
 public:
    LongRun() {
        log_ = small_.folder() / "long.rawlog";
        mrpt::io::CFileGZOutputStream file(log_, mrpt::io::OpenMode::TRUNCATE, 1);
        auto archive = mrpt::serialization::archiveFrom(file);
        auto observation = scan(log_start_ns, "LASER", 361);
        for (std::size_t i = 0; i < 361; ++i)
            observation->setScanRange(i, 3 + 0.01F * static_cast<float>(i % 60));
        for (int i = 0; i < 30'000; ++i) {
            observation->timestamp = stamp_to_mrpt(log_start_ns + i * second_ns / 50);
            archive << *observation;
        }
    }
    /// Starts it and returns when it is under way.
    pid_t start() {
        const pid_t child = ::fork();
        if (child == 0) {
            const int said = ::open((small_.folder() / "said").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
            ::dup2(said, STDERR_FILENO);
            ::execl(test::loopline_program().c_str(), "loopline", "run", small_.ini().c_str(), "--rawlog", log_.c_str(),
                    "--out", small_.out().c_str(), "--quiet", "--set", "outputs.record=CObservationLines",
                    nullptr);
            ::_exit(127);
        }
        for (int i = 0; i < 3000 && !std::filesystem::exists(small_.out() + "/recorded.rawlog.part"); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        return child;
    }
    static int end_of(pid_t child) {
        int status = 0;
        ::waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    std::string said() const { return file_bytes(small_.folder() / "said"); }
    const SmallRun& small() const { return small_; }

 private:
    SmallRun small_{"lines"};
    std::string log_;
};

/// The worker is the only child of the program.
pid_t worker_of(pid_t supervisor) {
    const std::string path =
        "/proc/" + std::to_string(supervisor) + "/task/" + std::to_string(supervisor) + "/children";
    return std::atoi(file_bytes(path).c_str());
}

}  // namespace

TEST(RunInterrupted, an_interruption_saves_what_there_is) {
    for (const int signal : {SIGINT, SIGTERM}) {
        LongRun run;
        const pid_t child = run.start();
        ::kill(child, signal);
        EXPECT_EQ(LongRun::end_of(child), 130);
        EXPECT_NE(run.said().find("interrupted"), std::string::npos) << run.said();
        const auto metrics = run.small().metrics();
        EXPECT_EQ(metrics["status"], "interrupted");
        EXPECT_GT(metrics["scans_read"].get<int>(), 0);
        EXPECT_LT(metrics["scans_read"].get<int>(), 30'000);
        EXPECT_TRUE(std::filesystem::exists(run.small().out() + "/recorded.rawlog"));
        EXPECT_FALSE(std::filesystem::exists(run.small().out() + "/recorded.rawlog.part"));
    }
}

TEST(RunInterrupted, a_killed_worker_is_told_plainly) {
    LongRun run;
    const pid_t child = run.start();
    const pid_t worker = worker_of(child);
    ASSERT_GT(worker, 1);
    ::kill(worker, SIGKILL);
    EXPECT_EQ(LongRun::end_of(child), 137);
    EXPECT_NE(run.said().find("killed from outside (signal 9)"), std::string::npos) << run.said();
    EXPECT_FALSE(std::filesystem::exists(run.small().out() + "/metrics.json"));
}

TEST(RunInterrupted, the_worker_does_not_outlive_its_supervisor) {
    LongRun run;
    const pid_t child = run.start();
    const pid_t worker = worker_of(child);
    ASSERT_GT(worker, 1);
    ::kill(child, SIGKILL);
    LongRun::end_of(child);
    for (int i = 0; i < 500 && ::kill(worker, 0) == 0; ++i) {
        const auto state = file_bytes("/proc/" + std::to_string(worker) + "/stat");
        if (state.find(") Z ") != std::string::npos) break;  // dead, nobody has fetched it
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    const auto state = file_bytes("/proc/" + std::to_string(worker) + "/stat");
    EXPECT_TRUE(state.empty() || state.find(") Z ") != std::string::npos) << state;
}
