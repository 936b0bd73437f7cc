/// Workers that crash, hang, throw or are killed, and what the supervisor makes of it.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <csignal>
#include <thread>

#include "commands/command.h"
#include "pipeline/log_source.h"
#include "pipeline/module_chain.h"
#include "pipeline/supervisor.h"
#include "pipeline_logs.h"
#include "support/built_files.h"

using namespace loopline;
using namespace loopline::testing;
using Stage = WorkerState::Stage;

namespace {

struct Outcome {
    int code = 0;
    std::string said;  ///< on stderr
};

Outcome supervised(const Supervision& supervision, const std::function<int(const Attempt&)>& work) {
    ::testing::internal::CaptureStderr();
    Outcome outcome;
    outcome.code = supervise(supervision, work);
    outcome.said = ::testing::internal::GetCapturedStderr();
    return outcome;
}

[[noreturn]] void crash() {
    std::signal(SIGSEGV, SIG_DFL);  // also under a sanitizer
    ::raise(SIGSEGV);
    std::abort();
}

/// Reads a log of ten scans as a worker does; `at_object` is called inside the guarded part of object number
/// `bad`.
int read_with_accident(const std::string& path, const Attempt& attempt, std::uint64_t bad,
                       void (*at_object)()) {
    ArchiveReader reader(path, attempt.rules);
    for (;;) {
        const bool limited = attempt.rules.limits[0].has_value();
        if (!limited && reader.objects() == bad) {
            attempt.rules.state->enter(Stage::reading, 0, bad);
            at_object();
        }
        if (!reader.next()) break;
    }
    std::cerr << reader.damage();
    return static_cast<int>(reader.objects());
}

class TenScans : public ::testing::Test {
 protected:
    void SetUp() override {
        std::vector<mrpt::serialization::CSerializable::Ptr> scans;
        for (int i = 0; i < 10; ++i) scans.push_back(scan(1'000'000'000 + i));
        write_log(folder_ / "log", scans);
        supervision_.rawlogs = {folder_ / "log"};
        supervision_.module_names = {"first", "second"};
        supervision_.map_builder_names = {"grid"};
    }
    Folder folder_;
    Supervision supervision_;
};

using Supervisor = TenScans;

}  // namespace

TEST_F(Supervisor, hands_on_the_exit_code_and_the_sentence_of_a_worker_that_ends) {
    EXPECT_EQ(supervised(supervision_, [](const Attempt&) { return 4; }).code, 4);
    const auto refused = supervised(supervision_, [](const Attempt&) -> int {
        throw CommandError(exit_input_data, "the log is no good");
    });
    EXPECT_EQ(refused.code, 3);
    EXPECT_EQ(refused.said, "loopline: the log is no good\n");
}

TEST_F(Supervisor, a_crash_inside_reading_ends_the_log_before_that_object) {
    const auto outcome = supervised(supervision_, [this](const Attempt& attempt) {
        return read_with_accident(folder_ / "log", attempt, 6, [] { crash(); });
    });
    EXPECT_EQ(outcome.code, 6);
    EXPECT_NE(outcome.said.find("damaged at object 7 (reading it crashes)"), std::string::npos)
        << outcome.said;
}

TEST_F(Supervisor, a_read_that_does_not_end_is_ended) {
    supervision_.longest_read = std::chrono::milliseconds(500);
    const auto outcome = supervised(supervision_, [this](const Attempt& attempt) {
        return read_with_accident(folder_ / "log", attempt, 3, [] {
            for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
        });
    });
    EXPECT_EQ(outcome.code, 3);
    EXPECT_NE(outcome.said.find("reading it does not end"), std::string::npos) << outcome.said;
}

TEST_F(Supervisor, a_failing_module_is_named_and_the_next_worker_stops_before_its_item) {
    int runs = 0;
    const auto fail_in_second = [](const Attempt& attempt) -> int {
        if (attempt.stop_before_sequence) {
            std::cerr << attempt.failure;
            return static_cast<int>(*attempt.stop_before_sequence);
        }
        attempt.rules.state->enter(Stage::module, 1, 17);
        throw std::runtime_error("no inverse\nwith a call stack");
    };
    auto outcome = supervised(supervision_, fail_in_second);
    EXPECT_EQ(outcome.code, 17);
    EXPECT_EQ(outcome.said,
              "internal error in module second at observation 17 (no inverse); everything before it is kept");
    outcome = supervised(supervision_, [&](const Attempt& attempt) -> int {
        if (attempt.stop_before_sequence) return 5;
        attempt.rules.state->enter(Stage::module, 0, 2);
        crash();
    });
    EXPECT_EQ(outcome.code, 5);
    EXPECT_EQ(runs, 0) << "workers share nothing with this process";
}

TEST_F(Supervisor, failures_that_nothing_can_be_kept_of_are_told) {
    auto outcome = supervised(supervision_, [](const Attempt& attempt) -> int {
        attempt.rules.state->enter(Stage::module, 0, WorkerState::at_the_end);
        crash();
    });
    EXPECT_EQ(outcome.code, 4);
    EXPECT_NE(outcome.said.find("module first after the last observation"), std::string::npos)
        << outcome.said;
    EXPECT_NE(outcome.said.find("nothing of this run is saved"), std::string::npos) << outcome.said;
    outcome = supervised(supervision_, [](const Attempt& attempt) -> int {
        attempt.rules.state->enter(Stage::drawing, 0, 0);
        std::_Exit(0);  // a library that ends the process is a failure too
    });
    EXPECT_EQ(outcome.code, 4);
    EXPECT_NE(outcome.said.find("everything but the pictures"), std::string::npos) << outcome.said;
}

TEST_F(Supervisor, a_failing_map_builder_costs_the_maps_only) {
    const auto outcome = supervised(supervision_, [](const Attempt& attempt) -> int {
        if (attempt.without_maps) {
            std::cerr << attempt.failure;
            return 4;
        }
        attempt.rules.state->enter(Stage::map_builder, 0, 3);
        crash();
    });
    EXPECT_EQ(outcome.code, 4);
    EXPECT_NE(outcome.said.find("in map builder grid at observation 3"), std::string::npos) << outcome.said;
}

TEST_F(Supervisor, a_kill_from_outside_is_told_and_not_taken_for_damage) {
    const auto outcome = supervised(supervision_, [](const Attempt& attempt) -> int {
        attempt.rules.state->enter(Stage::reading, 0, 4);
        ::kill(::getpid(), SIGKILL);
        return 0;
    });
    EXPECT_EQ(outcome.code, 137);
    EXPECT_NE(outcome.said.find("killed from outside (signal 9) while reading object 5"), std::string::npos)
        << outcome.said;
}

TEST_F(Supervisor, the_first_interruption_asks_to_stop_and_the_second_ends_at_once) {
    const auto interrupted = supervised(supervision_, [](const Attempt& attempt) {
        ::kill(::getppid(), SIGINT);
        while (!attempt.rules.state->stop_requested)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return 130;
    });
    EXPECT_EQ(interrupted.code, 130);
    EXPECT_EQ(interrupted.said, "");
    const auto twice = supervised(supervision_, [](const Attempt& attempt) -> int {
        ::kill(::getppid(), SIGTERM);
        while (!attempt.rules.state->stop_requested)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        std::this_thread::sleep_for(std::chrono::milliseconds(400));
        ::kill(::getppid(), SIGINT);
        for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
    });
    EXPECT_EQ(twice.code, 130);
    EXPECT_NE(twice.said.find("ended at once"), std::string::npos) << twice.said;
}

TEST_F(Supervisor, an_interruption_that_is_delivered_twice_is_one) {
    const auto interrupted = supervised(supervision_, [](const Attempt& attempt) {
        ::kill(::getppid(), SIGINT);
        while (!attempt.rules.state->stop_requested)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ::kill(::getppid(), SIGINT);  // as `timeout` does
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        return 130;
    });
    EXPECT_EQ(interrupted.code, 130);
    EXPECT_EQ(interrupted.said, "");
}

TEST_F(Supervisor, an_interruption_that_reaches_another_thread_of_the_program_asks_to_stop_too) {
    // The supervising thread blocks these signals, so the kernel gives them to one that does not.
    std::atomic<bool> done{false};
    std::thread other([&done] {
        while (!done) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
    for (const int signal : {SIGINT, SIGTERM}) {
        const auto interrupted = supervised(supervision_, [signal](const Attempt& attempt) {
            ::kill(::getppid(), signal);
            while (!attempt.rules.state->stop_requested)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return 130;
        });
        EXPECT_EQ(interrupted.code, 130);
    }
    done = true;
    other.join();
}

TEST_F(Supervisor, memory_is_limited_while_a_log_is_read_and_not_after) {
    if (test::built_with_address_sanitizer()) GTEST_SKIP() << "the limit can't be used with AddressSanitizer";
    rlimit before{}, inside{}, after{};
    getrlimit(RLIMIT_AS, &before);
    ReadGuard guard(nullptr, 0, 1000);
    guard.enter(0);
    getrlimit(RLIMIT_AS, &inside);
    EXPECT_LT(inside.rlim_cur, before.rlim_cur);
    guard.leave();
    guard.enter(1);
    getrlimit(RLIMIT_AS, &inside);
    EXPECT_LT(inside.rlim_cur, before.rlim_cur);
    guard.leave();
    guard.lift();
    getrlimit(RLIMIT_AS, &after);
    EXPECT_EQ(after.rlim_cur, before.rlim_cur);
    {
        ReadGuard forgotten(nullptr, 0, 1000);
        forgotten.enter(0);
    }
    getrlimit(RLIMIT_AS, &after);
    EXPECT_EQ(after.rlim_cur, before.rlim_cur);
}
