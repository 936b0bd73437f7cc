/// The map of a spinning lidar's run, from a simulated street to files and pictures, as a user makes it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/street_log.h"

using namespace loopline;
using namespace loopline::test;

namespace {

std::string street_map_ini(const TemporaryFolder& folder, const std::string& outputs) {
    return folder.write("run.ini", "[run]\nrawlog = " + street_log() +
                                       "\nmodules = lidar_mapping cloud_map\n[cloud_map]\nmax_range_m = "
                                       "25\n[outputs]\nreport = false\n" +
                                       outputs);
}

}  // namespace

TEST(CloudMap, gives_the_same_files_for_any_number_of_threads_and_pictures_of_them) {
    const TemporaryFolder folder;
    const std::string ini = street_map_ini(folder, "snapshots = false\n");
    std::map<std::string, std::string> first;
    for (const std::string threads : {"1", "2"}) {
        const auto out = folder / ("out" + threads);
        const auto result = run_loopline({"run", ini, "--out", out.string(), "--threads", threads});
        ASSERT_EQ(result.exit_code, 0) << result.err;
        for (const std::string end : {".ply", ".pcd", ".las"}) {
            const std::string bytes = file_text(out / ("map.cloud" + end));
            EXPECT_GT(bytes.size(), 400'000u);
            EXPECT_TRUE(first.emplace(end, bytes).first->second == bytes) << end;
        }
        const auto metrics = nlohmann::json::parse(file_text(out / "metrics.json"));
        EXPECT_GT(metrics.at("cloud_points").get<int>(), 25'000);
        EXPECT_EQ(metrics.at("cloud_sweeps"), metrics.at("scans_used"));
        EXPECT_EQ(metrics.at("modules").at("cloud_map").at("calls"), metrics.at("cloud_sweeps"));
        EXPECT_FALSE(std::filesystem::exists(out / "scratch"));
    }
    const auto out = folder / "out1";
    for (const std::string view : {"top", "axonometric"})
        for (const std::string& source :
             {out.string(), (out / "map.cloud.ply").string(), (out / "map.cloud.las").string()}) {
            const auto picture = folder / (view + ".png");
            const auto result = run_loopline(
                {"render", source, "--view", view, "--size", "640x480", "--out", picture.string()});
            ASSERT_EQ(result.exit_code, 0) << result.err;
            EXPECT_GT(std::filesystem::file_size(picture), 30'000u) << view << " of " << source;
            std::filesystem::remove(picture);
        }
}

TEST(CloudMap, by_the_final_poses_is_the_same_where_none_was_revised) {
    const TemporaryFolder folder;
    std::vector<int> points, moving;
    for (const std::string chain :
         {"modules = lidar_mapping cloud_map\n", "modules = lidar_mapping\nmaps = final_cloud_map\n"}) {
        const std::string ini = folder.write(
            "run.ini", "[run]\nrawlog = " + street_log() + "\n" + chain +
                           "[outputs]\nreport = false\nsnapshots = false\n[cloud_map]\nmax_range_m = "
                           "25\n[final_cloud_map]\nmax_range_m = 25\n");
        const auto out = folder / "out";
        const auto result = run_loopline({"run", ini, "--out", out.string()});
        ASSERT_EQ(result.exit_code, 0) << result.err;
        const auto metrics = nlohmann::json::parse(file_text(out / "metrics.json"));
        points.push_back(metrics.at("cloud_points").get<int>());
        moving.push_back(metrics.at("cloud_points_moving").get<int>());
        EXPECT_EQ(metrics.at("cloud_sweeps"), metrics.at("scans_used"));
        EXPECT_TRUE(std::filesystem::exists(out / "map.cloud.las"));
    }
    // A pose as observation is rounded otherwise: some points fall into the next cube.
    EXPECT_NEAR(points[0], points[1], 0.0001 * points[0]);
    EXPECT_NEAR(moving[0], moving[1], 0.01 * moving[0] + 10);
}

TEST(CloudMap, costs_nothing_where_nobody_wants_maps) {
    const TemporaryFolder folder;
    const std::string ini = street_map_ini(folder, "snapshots = false\nmaps = false\n");
    const auto out = folder / "out";
    const auto result = run_loopline({"run", ini, "--out", out.string()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_FALSE(std::filesystem::exists(out / "map.cloud.ply"));
    const auto metrics = nlohmann::json::parse(file_text(out / "metrics.json"));
    EXPECT_EQ(metrics.count("cloud_points"), 0u);
    EXPECT_LT(metrics.at("modules").at("cloud_map").at("mean_ms").get<double>(), 0.1);
}

TEST(CloudMap, says_so_where_no_pose_comes_under_the_label) {
    const TemporaryFolder folder;
    const std::string ini = street_map_ini(folder, "snapshots = false\n");
    const auto result =
        run_loopline({"run", ini, "--out", (folder / "out").string(), "--set", "cloud_map.poses=wheels"});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.err.find("no pose came under the label \"wheels\""), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out/map.cloud.ply"));
}

TEST(CloudMap, needs_a_module_that_publishes_poses) {
    const TemporaryFolder folder;
    const std::string ini =
        folder.write("run.ini", "[run]\nrawlog = " + street_log() + "\nmodules = cloud_map\n");
    const auto result = run_loopline({"run", ini, "--out", (folder / "out").string()});
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_NE(result.err.find("module cloud_map needs CObservationRobotPose"), std::string::npos)
        << result.err;
}
