/// Whole runs with modules that misbehave: what is kept, what is said, how it ends.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "commands/command.h"
#include "pipeline/log_facts.h"
#include "pipeline/run.h"
#include "pipeline_logs.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

constexpr int scans_in_log = 40;

/// A path with a pose for each scan, x = number of the scan; does something at one of them.
class Walker : public Module {
 public:
    Walker() = default;
    Walker(std::string name, std::uint64_t at, void (*accident)())
        : name_(std::move(name)), at_(at), accident_(accident) {}
    ModuleInfo info() const override { return {name_, "", {"CObservation2DRangeScan"}, {}, {}}; }
    ParameterTable parameters() override { return {name_, ""}; }
    void process(const StreamItem& item, Publisher& publisher) override {
        if (item.sequence == at_) accident_();
        const bool echo = path_.find(item.sequence).has_value();  // of the walker before it
        if (echo || !is_laser_scan(*item.observation)) return;
        path_.append(item.sequence, item.stamp_ns, Pose3(Pose2{double(item.sequence), 0, 0}),
                     Matrix6d::Identity());
        publisher.publish(scan(item.stamp_ns, "echo"));
    }
    void finish(Results& results) override {
        results.metrics["walked"] = static_cast<std::int64_t>(path_.size());
    }
    const Trajectory* trajectory() const override { return &path_; }
    mrpt::rtti::CObject* clone() const override { return new Walker(*this); }

 private:
    std::string name_;
    std::uint64_t at_ = ~std::uint64_t{0};
    void (*accident_)() = nullptr;
    Trajectory path_;
};

/// Counts what it was given, by the trajectory it was given.
class Counter : public MapBuilder {
 public:
    explicit Counter(std::uint64_t crash_at = ~std::uint64_t{0}) : crash_at_(crash_at) {}
    ModuleInfo info() const override { return {"counter", "", {}, {}, {}}; }
    ParameterTable parameters() override { return {"counter", ""}; }
    void start(const RunContext&, const Trajectory& trajectory) override { trajectory_ = &trajectory; }
    void insert(const StreamItem& item) override {
        if (item.sequence == crash_at_) std::abort();
        if (trajectory_->find(item.sequence)) ++with_pose_;
    }
    void finish(Results& results) override { results.metrics["drawn"] = with_pose_; }
    mrpt::rtti::CObject* clone() const override { return new Counter(*this); }

 private:
    std::uint64_t crash_at_;
    const Trajectory* trajectory_ = nullptr;
    std::int64_t with_pose_ = 0;
};

class Run : public ::testing::Test {
 protected:
    void SetUp() override {
        std::vector<mrpt::serialization::CSerializable::Ptr> scans;
        for (int i = 0; i < scans_in_log; ++i) scans.push_back(scan(1'000'000'000 + i * 100'000'000LL));
        write_log(folder_ / "log", scans);
        setup_.folder = folder_.path() / "out";
        setup_.experiment.config_path = "test.ini";
        setup_.experiment.run.rawlogs = {folder_ / "log"};
        setup_.experiment.outputs.snapshots = setup_.experiment.outputs.report = false;
        setup_.quiet = true;
        setup_.start = std::chrono::steady_clock::now();
    }
    void run() {
        Supervision supervision;
        supervision.rawlogs = setup_.experiment.run.rawlogs;
        for (const auto& module : setup_.experiment.modules)
            supervision.module_names.push_back(module->info().name);
        supervision.map_builder_names = {"counter"};
        ::testing::internal::CaptureStderr();
        code_ = supervise(supervision,
                          [this](const Attempt& attempt) { return run_experiment(setup_, attempt); });
        said_ = ::testing::internal::GetCapturedStderr();
        const auto text = file_bytes((setup_.folder / "metrics.json").string());
        metrics_ = text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
    }
    void use(std::uint64_t at, void (*accident)()) {
        setup_.experiment.modules = {std::make_shared<Walker>("walker", at, accident)};
    }
    std::size_t poses() { return rows_of((setup_.folder / "trajectory.tum").string()); }

    Folder folder_;
    RunSetup setup_;
    int code_ = -1;
    std::string said_;
    nlohmann::json metrics_;
};

void nothing() {}

}  // namespace

TEST_F(Run, an_intact_log_is_done) {
    use(0, nothing);
    setup_.experiment.map_builders = {std::make_shared<Counter>()};
    run();
    EXPECT_EQ(code_, 0) << said_;
    EXPECT_EQ(said_, "");
    EXPECT_EQ(metrics_["status"], "done");
    EXPECT_EQ(metrics_["scans_read"], scans_in_log);
    EXPECT_EQ(metrics_["scans_used"], scans_in_log);
    EXPECT_EQ(metrics_["drawn"], scans_in_log);
    EXPECT_EQ(metrics_["modules"]["walker"]["calls"], scans_in_log);
    EXPECT_NEAR(metrics_["distance_m"].get<double>(), scans_in_log - 1, 1e-9);
    EXPECT_GT(metrics_["peak_memory_mb"].get<double>(), 1);
    EXPECT_EQ(poses(), static_cast<std::size_t>(scans_in_log));
}

TEST_F(Run, maps_are_not_drawn_where_no_output_needs_them) {
    use(0, nothing);
    setup_.experiment.map_builders = {std::make_shared<Counter>()};
    setup_.experiment.outputs.maps = false;
    run();
    EXPECT_EQ(code_, 0);
    EXPECT_FALSE(metrics_.contains("drawn"));
}

TEST_F(Run, a_module_that_throws_or_crashes_costs_what_comes_after) {
    use(25, [] { throw std::runtime_error("singular"); });
    run();
    EXPECT_EQ(code_, exit_refused);
    EXPECT_NE(said_.find("internal error in module walker at observation 25 (singular)"), std::string::npos)
        << said_;
    EXPECT_EQ(metrics_["status"], "refused");
    EXPECT_EQ(poses(), 25u);

    use(30, [] {
        std::signal(SIGSEGV, SIG_DFL);
        ::raise(SIGSEGV);
    });
    run();
    EXPECT_EQ(code_, exit_refused);
    EXPECT_NE(said_.find("module walker at observation 30 (signal 11"), std::string::npos) << said_;
    EXPECT_EQ(poses(), 30u);
}

TEST_F(Run, a_map_builder_that_crashes_costs_the_maps) {
    use(0, nothing);
    setup_.experiment.map_builders = {std::make_shared<Counter>(5)};
    run();
    EXPECT_EQ(code_, exit_refused);
    EXPECT_NE(said_.find("in map builder counter at observation 5"), std::string::npos) << said_;
    EXPECT_EQ(poses(), static_cast<std::size_t>(scans_in_log));
    EXPECT_FALSE(metrics_.contains("drawn"));
}

TEST_F(Run, an_interruption_saves_what_was_read) {
    use(20, [] {
        ::kill(::getppid(), SIGINT);
        ::sleep(1);  // the supervisor hears of it meanwhile
    });
    setup_.experiment.map_builders = {std::make_shared<Counter>()};
    run();
    EXPECT_EQ(code_, exit_interrupted);
    EXPECT_EQ(metrics_["status"], "interrupted");
    EXPECT_EQ(poses(), 21u);
    EXPECT_EQ(metrics_["walked"], 21) << "finish() was called";
    EXPECT_EQ(metrics_["drawn"], 21) << "the maps are of the same part of the log";
    EXPECT_NE(said_.find("interrupted"), std::string::npos);
}

TEST_F(Run, a_cut_log_is_processed_as_far_as_it_goes) {
    const auto whole = file_bytes(folder_ / "log");
    write_file(folder_ / "log", whole.substr(0, whole.size() - 12));
    use(0, nothing);
    run();
    EXPECT_EQ(code_, exit_input_data);
    EXPECT_EQ(metrics_["status"], "damaged_input");
    EXPECT_EQ(poses(), metrics_["scans_read"].get<std::size_t>());
    EXPECT_GT(poses(), 20u);
    EXPECT_NE(said_.find(folder_ / "log"), std::string::npos);
}

TEST_F(Run, nothing_is_written_where_the_log_has_not_what_a_module_needs) {
    write_log(folder_ / "log", {frame({}), move(1, 0, 0)});
    use(0, nothing);
    run();
    EXPECT_EQ(code_, exit_input_data);
    EXPECT_NE(said_.find("holds no observation"), std::string::npos) << said_;
    auto odometry = mrpt::obs::CObservationOdometry::Create();
    odometry->sensorLabel = "ODO";
    write_log(folder_ / "log", {odometry});
    run();
    EXPECT_EQ(code_, exit_input_data);
    EXPECT_NE(
        said_.find("walker needs CObservation2DRangeScan, and this log holds 1 CObservationOdometry (ODO)"),
        std::string::npos)
        << said_;
    EXPECT_FALSE(std::filesystem::exists(setup_.folder));
}

TEST_F(Run, the_chosen_module_gives_the_trajectory) {
    setup_.experiment.modules = {std::make_shared<Walker>("odometry", 0, nothing),
                                 std::make_shared<Walker>("second", 0, nothing)};
    setup_.experiment.run.trajectory = "odometry";
    run();
    EXPECT_EQ(code_, 0);
    EXPECT_EQ(poses(), static_cast<std::size_t>(scans_in_log));
    EXPECT_TRUE(std::filesystem::exists(setup_.folder / "odometry.tum"));
    EXPECT_EQ(metrics_["modules"]["second"]["calls"], 2 * scans_in_log) << "its scans and the echoes";
}

TEST_F(Run, recorded_observations_are_a_log) {
    use(0, nothing);
    setup_.experiment.outputs.record = {"echo"};
    run();
    EXPECT_EQ(code_, 0) << said_;
    setup_.experiment.run.rawlogs = {(setup_.folder / "recorded.rawlog").string()};
    setup_.folder = folder_.path() / "again";
    run();
    EXPECT_EQ(code_, 0) << said_;
    EXPECT_EQ(metrics_["scans_read"], scans_in_log);
}
