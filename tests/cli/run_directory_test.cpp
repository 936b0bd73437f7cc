/// The run directory: where it is, what is replaced, what is left alone, and that the same run writes the
/// same bytes.
#include <gtest/gtest.h>

#include "cli/run_support.h"

using namespace loopline;
using namespace loopline::testing;

TEST(RunDirectory, is_runs_NAME_in_the_working_directory) {
    const SmallRun small;
    const auto result = test::run_loopline({"run", small.ini()}, {}, small.folder().path());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    EXPECT_NE(result.out.find("225 scans"), std::string::npos) << result.out;
    EXPECT_NE(result.out.find("runs/small"), std::string::npos) << result.out;
    EXPECT_EQ(result.out.find('\r'), std::string::npos) << "no progress line in a pipe";
    for (const char* file : {"trajectory.tum", "trajectory_online.tum", "odometry.tum", "covariance.csv",
                             "metrics.json", "config.ini", "manifest.json"})
        EXPECT_TRUE(std::filesystem::exists(small.folder().path() / "runs/small" / file)) << file;
}

TEST(RunDirectory, quiet_says_nothing_when_all_is_well) {
    const SmallRun small;
    const auto result = small.run(telecom_log);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(result.err, "");
}

TEST(RunDirectory, the_same_run_writes_the_same_bytes) {
    const SmallRun small("odometry lines");
    const std::vector<std::string> record{"--set", "outputs.record=CObservationLines"};
    ASSERT_EQ(small.run(telecom_log, record).exit_code, 0);
    const std::vector<std::string> files{"trajectory.tum", "trajectory_online.tum",
                                         "odometry.tum",   "covariance.csv",
                                         "config.ini",     "recorded.rawlog"};
    std::vector<std::string> first;
    for (const auto& file : files) first.push_back(small.text_of(file));
    auto more_threads = record;
    more_threads.insert(more_threads.end(), {"--threads", "3"});
    ASSERT_EQ(small.run(telecom_log, more_threads).exit_code, 0);
    for (std::size_t i = 0; i < files.size(); ++i) {
        EXPECT_FALSE(first[i].empty()) << files[i];
        EXPECT_TRUE(first[i] == small.text_of(files[i])) << files[i];
    }
}

TEST(RunDirectory, what_is_not_ours_stays) {
    const SmallRun small;
    std::filesystem::create_directories(small.out());
    write_file(small.out() + "/thesis.tex", "years of work");
    write_file(small.out() + "/metrics.json", "an old one");
    ASSERT_EQ(small.run(telecom_log).exit_code, 0);
    EXPECT_EQ(small.text_of("thesis.tex"), "years of work");
    EXPECT_EQ(small.metrics()["status"], "done");
}

TEST(RunDirectory, a_place_that_can_not_be_one_is_refused_before_the_run) {
    const SmallRun small;
    write_file(small.folder() / "file", "");
    for (const char* place : {"file", "file/below"}) {
        const auto result =
            test::run_loopline({"run", small.ini(), "--out", small.folder() / place, "--quiet"});
        EXPECT_EQ(result.exit_code, 2);
        EXPECT_NE(result.err.find("is a file; name a folder"), std::string::npos) << result.err;
    }
}

TEST(RunDirectory, knows_the_inputs_by_their_hash) {
    const SmallRun small;
    const std::string log = small.folder() / "log.rawlog";
    write_log(log, drive(5));
    ASSERT_EQ(small.run(log).exit_code, 0);
    const auto manifest = nlohmann::json::parse(small.text_of("manifest.json"));
    const auto shown = test::run_program({"sha256sum", log}).out;
    EXPECT_EQ(manifest["inputs"][0]["sha256"], shown.substr(0, 64));
    EXPECT_EQ(manifest["inputs"][0]["objects_read"], 9);
}
