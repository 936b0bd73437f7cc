/// Module landmark_odometry as a user runs it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/grove_log.h"

using namespace loopline;

namespace {

struct Outcome {
    test::ProgramResult result;
    nlohmann::json metrics;
};

Outcome run(const test::TemporaryFolder& folder, const std::string& keys, const std::string& log) {
    const auto ini =
        folder.write("run.ini", "[run]\nmodules = landmark_odometry\nrawlog = " + log +
                                    "\n[outputs]\nmaps = false\nsnapshots = false\nreport = false\n" + keys);
    Outcome outcome;
    outcome.result = test::run_loopline({"run", ini, "--out", (folder / "out").string(), "--quiet"});
    if (outcome.result.exit_code == 0)
        outcome.metrics = nlohmann::json::parse(test::file_text(folder / "out" / "metrics.json"));
    return outcome;
}

std::string truth_of(const std::string& log) {
    return log.substr(0, log.rfind(".rawlog")) + ".truth.tum";
}

TEST(LandmarkRuns, of_a_drive_among_trees_hold_what_its_wheels_do_not) {
    const std::string log = test::grove_log(), truth = "[evaluation]\ntruth = " + truth_of(log) + "\n";
    const test::TemporaryFolder folder;
    const Outcome held = run(folder, truth, log);
    ASSERT_EQ(held.result.exit_code, 0) << held.result.err;
    EXPECT_LT(held.metrics.at("ate_rmse_m").get<double>(), 0.15);
    EXPECT_GT(held.metrics.at("landmarks").get<int>(), 20);
    EXPECT_GT(held.metrics.at("landmark_sightings_matched").get<int>(), 500);
    EXPECT_NEAR(held.metrics.at("landmark_mean_square").get<double>(), 1, 0.2);
}

TEST(LandmarkRuns, draw_a_map_of_the_trees) {
    const test::TemporaryFolder folder;
    const auto ini = folder.write(
        "run.ini", "[run]\nmodules = landmark_odometry\nmaps = landmarks\nrawlog = " + test::grove_log() +
                       "\n[outputs]\nreport = false\n");
    const auto result = test::run_loopline({"run", ini, "--out", (folder / "out").string(), "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto metrics = nlohmann::json::parse(test::file_text(folder / "out" / "metrics.json"));
    // 0.008 trees a square metre, seen up to 30 m beside 80 m of way.
    EXPECT_GT(metrics.at("landmarks_mapped").get<int>(), 25);
    EXPECT_LT(metrics.at("landmarks_mapped").get<int>(), 70);
    EXPECT_TRUE(std::filesystem::exists(folder / "out" / "map.points.ply"));
    EXPECT_TRUE(std::filesystem::exists(folder / "out" / "snapshots" / "top.png"));
}

TEST(LandmarkRuns, say_what_is_missing) {
    const test::TemporaryFolder folder;
    const Outcome named = run(folder, "[landmark_odometry]\nodometry = wheel\n", test::grove_log());
    EXPECT_NE(named.result.exit_code, 0);
    EXPECT_NE(named.result.err.find("[landmark_odometry] odometry"), std::string::npos) << named.result.err;
    const Outcome itself =
        run(folder, "[landmark_odometry]\nodometry = landmark_odometry\n", test::grove_log());
    EXPECT_NE(itself.result.err.find("would lead it by itself"), std::string::npos) << itself.result.err;
}

}  // namespace
