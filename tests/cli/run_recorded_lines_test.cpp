/// Lines that one run recorded are the whole input of another: the same estimate, byte for byte, without
/// scans.
#include <gtest/gtest.h>

#include "cli/run_support.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

const char* const estimate_files[] = {"trajectory.tum", "trajectory_online.tum", "covariance.csv",
                                      "map.lines.csv"};

class RecordedLines : public ::testing::Test {
 protected:
    void SetUp() override {
        const auto result = from_scans_.run(
            telecom_log, {"--set", "outputs.record=lines odometry_at_scan", "--set", "outputs.maps=true"});
        ASSERT_EQ(result.exit_code, 0) << result.err;
        recorded_ = from_scans_.out() + "/recorded.rawlog";
    }
    SmallRun from_scans_{"odometry lines line_slam"};
    SmallRun from_lines_{"line_slam"};
    std::string recorded_;
};

}  // namespace

TEST_F(RecordedLines, give_the_trajectory_of_the_run_that_recorded_them) {
    const auto result = from_lines_.run(recorded_, {"--set", "outputs.maps=true"});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.err, "");
    EXPECT_EQ(from_lines_.rows_of_trajectory(), 225u);
    for (const char* file : estimate_files) {
        EXPECT_NE(from_lines_.text_of(file), "") << file;
        EXPECT_TRUE(from_lines_.text_of(file) == from_scans_.text_of(file)) << file;
    }
    EXPECT_EQ(from_lines_.metrics()["modules"]["line_slam"]["calls"], 225);
}

TEST_F(RecordedLines, draw_no_map_of_scans_and_say_so) {
    const std::vector<std::string> with_grid{"--set", "outputs.maps=true", "--set", "run.maps=grid"};
    const auto result = from_lines_.run(recorded_, with_grid);
    const std::string sentence = "no map grid is drawn: it needs CObservation2DRangeScan, and this log holds";
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.err.find("warning: " + sentence), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(from_lines_.out() + "/map.grid.pgm"));
    EXPECT_FALSE(std::filesystem::exists(from_lines_.out() + "/map.grid.gridmap"));

    std::vector<std::string> check{"check", from_lines_.ini(), "--rawlog", recorded_};
    check.insert(check.end(), with_grid.begin(), with_grid.end());
    const auto checked = test::run_loopline(check, {"COLUMNS=100"});
    EXPECT_EQ(checked.exit_code, 0);
    EXPECT_NE(checked.out.find("To look at:\n  no map grid is drawn"), std::string::npos) << checked.out;
    EXPECT_NE(checked.out.find("it will run"), std::string::npos) << checked.out;
}
