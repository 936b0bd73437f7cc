/// Odometry of a spinning lidar, alone and in front of a map, and wheels in front of a map, as a user runs
/// them.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/street_log.h"

using namespace loopline;
using namespace loopline::test;

namespace {

/// A run of a log with its truth, and what metrics.json has.
nlohmann::json metrics_of(const TemporaryFolder& folder, const std::string& log, const std::string& keys,
                          const std::string& name) {
    const std::string ini = (folder / (name + ".ini")).string(), out = (folder / name).string();
    std::ofstream(ini) << "[run]\nrawlog = " << log << "\n"
                       << keys << "[outputs]\nsnapshots = false\nreport = false\n[evaluation]\ntruth = "
                       << log.substr(0, log.size() - 7) << ".truth.tum\n";
    const auto result = run_loopline({"run", ini, "--out", out});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::ifstream file(out + "/metrics.json");
    return result.exit_code == 0 ? nlohmann::json::parse(file) : nlohmann::json();
}

std::size_t lines_of(const std::string& path) {
    std::ifstream file(path);
    std::size_t count = 0;
    for (std::string line; std::getline(file, line);) ++count;
    return count;
}

}  // namespace

TEST(LidarOdometryRuns, alone_and_in_front_of_a_map_that_is_matched_with_every_third_sweep) {
    const TemporaryFolder folder;
    const auto alone = metrics_of(folder, short_street_log(),
                                  "modules = lidar_odometry\ntrajectory = lidar_odometry\n", "alone");
    ASSERT_FALSE(alone.is_null());
    EXPECT_LT(alone.at("ate_rmse_m").get<double>(), 0.06);
    EXPECT_EQ(alone.at("lidar_odometry_degenerate").get<int>(), 0);
    EXPECT_GT(alone.at("lidar_odometry_planes_mean").get<double>(), 100);

    const auto both = metrics_of(folder, short_street_log(),
                                 "modules = lidar_odometry lidar_mapping\ntrajectory = lidar_mapping\n"
                                 "[lidar_mapping]\nodometry = lidar_odometry\nevery_sweeps = 3\n",
                                 "both");
    ASSERT_FALSE(both.is_null());
    EXPECT_LT(both.at("ate_rmse_m").get<double>(), 0.06);
    // Told per sweep, though two poses come with each.
    EXPECT_EQ(both.at("modules").at("lidar_mapping").at("calls"), both.at("scans_used"));
    // Each sweep has its pose, also those between.
    EXPECT_EQ(lines_of((folder / "both/trajectory.tum").string()),
              lines_of((folder / "alone/trajectory.tum").string()));
}

TEST(LidarOdometryRuns, wheels_in_front_of_a_map) {
    const TemporaryFolder folder;
    // The readings themselves, or what module odometry makes of them at the stamp of each sweep.
    const std::vector<std::pair<std::string, std::string>> chains = {
        {"lidar_mapping", "wheels"}, {"odometry lidar_mapping", "odometry_at_sweep"}};
    for (const auto& [modules, odometry] : chains) {
        const auto driven = metrics_of(
            folder, short_street_log(),
            "modules = " + modules + "\ntrajectory = lidar_mapping\n[lidar_mapping]\nodometry = " + odometry +
                "\nevery_sweeps = 4\n[odometry]\nsweeps = true\n",
            odometry);
        ASSERT_FALSE(driven.is_null());
        EXPECT_LT(driven.at("ate_rmse_m").get<double>(), 0.1);
        EXPECT_EQ(driven.at("scans_used"), driven.at("modules").at("lidar_mapping").at("calls"));
    }
    // Dead reckoning has a pose at each sweep, too.
    EXPECT_EQ(lines_of((folder / "odometry_at_sweep/odometry.tum").string()),
              lines_of((folder / "odometry_at_sweep/trajectory.tum").string()));
}

TEST(LidarOdometryRuns, an_odometry_that_never_comes_is_warned_of) {
    const TemporaryFolder folder;
    const std::string ini = (folder / "run.ini").string();
    std::ofstream(ini) << "[run]\nrawlog = " << short_street_log()
                       << "\nmodules = lidar_mapping\ntrajectory = lidar_mapping\n[lidar_mapping]\n"
                          "odometry = nobody\n[outputs]\nsnapshots = false\nreport = false\n";
    const auto result = run_loopline({"run", ini, "--out", (folder / "out").string()});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.err.find("odometry = nobody"), std::string::npos) << result.err;
}
