/// The path of a spinning lidar, from a simulated street to the figures, as a user runs it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/street_log.h"
#include "support/velodyne_packets.h"

using namespace loopline;
using namespace loopline::test;

namespace {

std::string bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST(LidarMapping, follows_a_street_and_gives_the_same_bytes_for_any_number_of_threads) {
    const TemporaryFolder folder;
    const std::string log = street_log(), truth = log.substr(0, log.size() - 7) + ".truth.tum",
                      ini = (folder / "run.ini").string();
    std::ofstream(ini) << "[run]\nrawlog = " << log
                       << "\nmodules = lidar_mapping\ntrajectory = lidar_mapping\n[outputs]\n"
                          "snapshots = false\nreport = false\n";
    std::vector<std::string> paths;
    for (const std::string threads : {"1", "2"}) {
        const std::string out = (folder / ("out" + threads)).string();
        const auto result = run_loopline(
            {"run", ini, "--out", out, "--threads", threads, "--set", "evaluation.truth=" + truth});
        ASSERT_EQ(result.exit_code, 0) << result.err;
        const auto metrics = nlohmann::json::parse(bytes_of(out + "/metrics.json"));
        EXPECT_LT(metrics.at("ate_rmse_m").get<double>(), 0.015);
        EXPECT_LT(metrics.at("ate_max_m").get<double>(), 0.05) << "as where it sets off";
        // 3 in the mean of many drives.
        EXPECT_GT(metrics.at("nees_mean").get<double>(), 0.2);
        EXPECT_LT(metrics.at("nees_mean").get<double>(), 9);
        EXPECT_EQ(metrics.at("scans_degenerate").get<int>(), 0);
        paths.push_back(bytes_of(out + "/trajectory.tum"));
    }
    EXPECT_EQ(paths[0], paths[1]);
}

TEST(LidarMapping, says_so_where_a_log_has_no_sweep_and_so_does_the_odometry) {
    const TemporaryFolder folder;
    const std::string log = (folder / "square.rawlog").string();
    std::ofstream(folder / "square.ini")
        << "[simulation]\nsensors = wheels\n[world]\nwall_m = -1 -1  3 "
           "-1\n[route]\ndrive = pushed\nwaypoint_m = 0 0\nwaypoint_m = 2 0\n";
    ASSERT_EQ(run_loopline({"simulate", (folder / "square.ini").string(), "--out", log}).exit_code, 0);
    for (const std::string module : {"lidar_mapping", "lidar_odometry"}) {
        const std::string ini = (folder / (module + ".ini")).string();
        std::ofstream(ini) << "[run]\nrawlog = " << log << "\nmodules = " << module
                           << "\n[evaluation]\ntruth_beside_log = false\n";
        const auto result = run_loopline({"run", ini, "--out", (folder / module).string()});
        EXPECT_EQ(result.exit_code, 4);
        EXPECT_NE(result.err.find("no sweep of a spinning lidar"), std::string::npos) << result.err;
    }
}

TEST(LidarMapping, follows_packets_of_a_velodyne_by_their_own_times) {
    const TemporaryFolder folder;
    const std::string images = (folder / "street.rawlog").string(),
                      packets = (folder / "packets.rawlog").string(),
                      truth = (folder / "street.truth.tum").string();
    const std::string scenario = folder.write("street.ini", street_scenario);
    ASSERT_EQ(run_loopline({"simulate", scenario, "--out", images, "--set", "spinning_lidar.columns=2160"})
                  .exit_code,
              0);
    write_as_packets(images, packets);
    const std::string ini =
        folder.write("run.ini", "[run]\nrawlog = " + packets +
                                    "\nmodules = lidar_mapping cloud_map\n[outputs]\nsnapshots = "
                                    "false\nreport = false\n[evaluation]\ntruth = " +
                                    truth + "\n");
    const auto result = run_loopline({"run", ini, "--out", (folder / "out").string()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto metrics = nlohmann::json::parse(bytes_of((folder / "out/metrics.json").string()));
    // A real one fires its beams one after the other, the simulated one a column at once: up to 0.13 degrees
    // apart.
    EXPECT_LT(metrics.at("ate_rmse_m").get<double>(), 0.05);
    EXPECT_EQ(metrics.at("cloud_sweeps"), metrics.at("truth_poses_used"));
    const std::string ply = bytes_of((folder / "out/map.cloud.ply").string());
    EXPECT_NE(ply.find("property float intensity"), std::string::npos);
}
