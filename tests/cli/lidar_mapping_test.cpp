/// The path of a spinning lidar, from a simulated street to the figures, as a user runs it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/street_log.h"

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
        EXPECT_LT(metrics.at("ate_rmse_m").get<double>(), 0.03);
        EXPECT_EQ(metrics.at("scans_degenerate").get<int>(), 0);
        paths.push_back(bytes_of(out + "/trajectory.tum"));
    }
    EXPECT_EQ(paths[0], paths[1]);
}

TEST(LidarMapping, says_so_where_a_log_has_no_sweep) {
    const TemporaryFolder folder;
    const std::string ini = (folder / "run.ini").string(), log = (folder / "square.rawlog").string();
    std::ofstream(folder / "square.ini")
        << "[simulation]\nsensors = wheels\n[world]\nwall_m = -1 -1  3 "
           "-1\n[route]\ndrive = pushed\nwaypoint_m = 0 0\nwaypoint_m = 2 0\n";
    ASSERT_EQ(run_loopline({"simulate", (folder / "square.ini").string(), "--out", log}).exit_code, 0);
    std::ofstream(ini) << "[run]\nrawlog = " << log
                       << "\nmodules = lidar_mapping\n[evaluation]\ntruth_beside_log = false\n";
    const auto result = run_loopline({"run", ini, "--out", (folder / "out").string()});
    EXPECT_EQ(result.exit_code, 4);
    EXPECT_NE(result.err.find("no sweep of a spinning lidar"), std::string::npos) << result.err;
}
