/// Broken runs of many kinds of modules and logs: each goes on to the same bytes.
#include "support/grove_log.h"
#include "support/placed_street_map.h"
#include "support/resumed_run.h"
#include "support/ring_log.h"
#include "support/street_log.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

const std::string chain = "modules = odometry lines line_slam\nmaps = grid\n";
const char* const simul_log =
    "/usr/share/mrpt/datasets/graphslam-engine-demos/action_observations_map/simul.rawlog";

}  // namespace

TEST(ResumedRuns, wherever_they_were_broken_off) {
    expect_same_after_breaks("checkpoint_items = 25\n" + chain);
}

TEST(ResumedRuns, where_a_step_of_the_filter_takes_seven_scans) {
    expect_same_after_breaks("checkpoint_items = 10\n" + chain + "[line_slam]\ninterval_scans = 7\n");
}

TEST(ResumedRuns, of_one_that_maps_on_a_grid_and_closes_its_loops_either_way) {
    const std::string grid =
        "checkpoint_items = 40\nmodules = odometry grid_slam\nmaps = grid\n[grid_slam]\n";
    expect_same_after_breaks(grid + "weights = joint\n");
    const BrokenRuns runs(telecom_log, grid + "weights = covariance\n");
    ASSERT_EQ(runs.run("whole", false), 0);
    EXPECT_EQ(runs.run("broken", false, Break::kill_all, 400), 137);
    EXPECT_EQ(runs.run("broken", true), 0);
    runs.expect_same("broken", "whole");
}

TEST(ResumedRuns, of_a_cart_that_navigates_by_its_imu_and_closes_its_loops_either_way) {
    const std::string grid =
        "checkpoint_items = 100\nmodules = odometry grid_slam\n[odometry]\nscans = horizontal_laser\n"
        "[grid_slam]\nactive_sigma_m = 0.03\n";
    for (const std::string how :
         {"navigation = imu+wheel\nweights = joint\n", "navigation = imu\nweights = covariance\n"}) {
        SCOPED_TRACE(how);
        const BrokenRuns runs(test::ring_log_with_imu(), grid + how);
        ASSERT_EQ(runs.run("whole", false), 0);
        const auto metrics = nlohmann::json::parse(file_bytes(runs.path("whole") + "/metrics.json"));
        EXPECT_TRUE(metrics.at("imu_aligned").get<bool>());
        EXPECT_GE(metrics.at("loops_found").get<int>(), 1);
        // At rest, on the first way round, and after a loop.
        for (const std::uint64_t at : {300U, 3000U, 7500U}) {
            EXPECT_EQ(runs.run("broken", false, Break::kill_all, at), 137);
            EXPECT_EQ(runs.run("broken", true), 0);
            runs.expect_same("broken", "whole");
            std::filesystem::remove_all(runs.path("broken"));
        }
    }
}

TEST(ResumedRuns, of_a_long_log_with_a_recording_of_several_blocks) {
    if (!std::filesystem::exists(simul_log)) GTEST_SKIP() << simul_log << " is not there";
    const BrokenRuns runs(simul_log,
                          "checkpoint_items = 250\n" + chain + "[line_slam]\ninterval_scans = 7\n");
    ASSERT_EQ(runs.run("whole", false), 0);
    EXPECT_EQ(runs.run("broken", false, Break::kill_all, 2600), 137);
    EXPECT_EQ(runs.run("broken", true, Break::interrupt, 3100), 130);
    std::filesystem::copy(runs.path("broken"), runs.path("robbed"));
    EXPECT_EQ(runs.run("broken", true), 0);
    runs.expect_same("broken", "whole");

    // The complete blocks of the recording are not in the checkpoint.
    std::filesystem::resize_file(runs.path("robbed") + "/recorded.rawlog", 1000);
    EXPECT_EQ(runs.run("robbed", true), exit_configuration);
}

TEST(ResumedRuns, of_one_that_is_localised_in_a_finished_map) {
    const BrokenRuns mapping(telecom_log, "checkpoint_s = 0\nmodules = odometry grid_slam\nmaps = grid\n");
    ASSERT_EQ(mapping.run("map", false), 0);
    const std::string map = mapping.path("map"), yaml = file_bytes(map + "/map.grid.yaml"),
                      pgm = file_bytes(map + "/map.grid.pgm");
    for (const std::string start : {"given", "global"}) {
        const BrokenRuns runs(telecom_log,
                              "checkpoint_items = 25\nmodules = odometry grid_localisation\n"
                              "[grid_localisation]\nmap = " +
                                  map + "\nstart = " + start + "\n");
        ASSERT_EQ(runs.run("whole", false), 0) << start;
        for (const std::uint64_t at : {30U, 250U}) {
            EXPECT_EQ(runs.run("broken", false, Break::kill_all, at), 137);
            EXPECT_EQ(runs.run("broken", true), 0);
            runs.expect_same("broken", "whole");
            std::filesystem::remove_all(runs.path("broken"));
        }
        EXPECT_EQ(file_bytes(map + "/map.grid.yaml"), yaml);
        EXPECT_TRUE(file_bytes(map + "/map.grid.pgm") == pgm);
        if (start == "given") continue;
        // With another map it is not gone on with.
        EXPECT_EQ(runs.run("broken", false, Break::kill_all, 250), 137);
        std::string other = pgm;
        other[other.size() / 2] = static_cast<char>(other[other.size() / 2] == 0 ? 254 : 0);
        write_file(map + "/map.grid.pgm", other);
        EXPECT_EQ(runs.run("broken", true), exit_configuration);
        write_file(map + "/map.grid.pgm", pgm);
        EXPECT_EQ(runs.run("broken", true), 0);
    }
}

TEST(ResumedRuns, of_one_that_follows_a_spinning_lidar) {
    const BrokenRuns runs(test::street_log(), "checkpoint_items = 1\nmodules = lidar_mapping\n");
    ASSERT_EQ(runs.run("whole", false), 0);
    // After the first sweep, whose motion is not known yet, and on the way.
    for (const std::uint64_t at : {1U, 45U}) {
        EXPECT_EQ(runs.run("broken", false, Break::kill_all, at), 137);
        EXPECT_EQ(runs.run("broken", true), 0);
        runs.expect_same("broken", "whole");
        std::filesystem::remove_all(runs.path("broken"));
    }
}

TEST(ResumedRuns, of_one_that_makes_a_cloud_of_a_street) {
    const BrokenRuns runs(
        test::street_log(),
        "checkpoint_items = 7\nmodules = lidar_mapping cloud_map\n[cloud_map]\nmax_range_m = 20\n"
        "views = 6\n");
    ASSERT_EQ(runs.run("whole", false), 0);
    const std::string map = "/map.cloud.ply", whole = file_bytes(runs.path("whole") + map);
    EXPECT_GT(whole.size(), 1'000'000u);
    EXPECT_EQ(runs.run("broken", false, Break::kill_all, 60), 137);
    EXPECT_EQ(runs.run("broken", true, Break::interrupt, 80), 130);
    const std::string half = file_bytes(runs.path("broken") + map);
    EXPECT_GT(half.size(), whole.size() / 2);  // what there is is written
    EXPECT_LT(half.size(), whole.size());
    EXPECT_EQ(runs.run("broken", true), 0);
    runs.expect_same("broken", "whole");
}

TEST(ResumedRuns, of_one_that_is_placed_on_the_earth) {
    const BrokenRuns runs(test::placed_street_log(),
                          "checkpoint_items = 10\nmodules = lidar_mapping fusion\ntrajectory = fusion\n");
    ASSERT_EQ(runs.run("whole", false), 0);
    EXPECT_TRUE(std::filesystem::exists(runs.path("whole") + "/trajectory.geojson")) << "is placed";
    EXPECT_EQ(runs.run("broken", false, Break::kill_all, 12), 137);  // before the heading is known
    EXPECT_EQ(runs.run("broken", true, Break::kill_all, 100), 137);  // after
    EXPECT_EQ(runs.run("broken", true), 0);
    runs.expect_same("broken", "whole");
}

// Wheels that lead a mapper whose pose comes back; wheels beside a lidar odometry, both leading the mapper;
// wheels alone; and the paper's filter.
TEST(ResumedRuns, of_fusions_with_wheels) {
    const std::string inis[] = {
        "modules = odometry fusion lidar_mapping\ntrajectory = fusion\n[odometry]\nsweeps = true\n[fusion]\n"
        "wheels = odometry_at_sweep\n[lidar_mapping]\nodometry = calibrated_wheels\n",
        "modules = odometry lidar_odometry fusion lidar_mapping\ntrajectory = fusion\n[odometry]\nsweeps = "
        "true\n[fusion]\nmotion = lidar_odometry\nwheels = odometry_at_sweep\n[lidar_mapping]\nodometry = "
        "fused_odometry\n",
        "modules = fusion\ntrajectory = fusion\n[fusion]\nmotion =\nwheels = wheels\nwithhold_s = "
        "1\nwithhold_every_s = 7\n",
        "modules = lidar_mapping fusion\ntrajectory = fusion\n[fusion]\nfilter = paper\nsync = "
        "threshold\nwheels = wheels\n"};
    for (const std::string& ini : inis) {
        const BrokenRuns runs(test::placed_street_log(), "checkpoint_items = 25\n" + ini);
        ASSERT_EQ(runs.run("whole", false), 0);
        EXPECT_TRUE(std::filesystem::exists(runs.path("whole") + "/trajectory.geojson")) << "is placed";
        EXPECT_EQ(file_bytes(runs.path("whole") + "/metrics.json").find("\"wheels_used\": 0,"),
                  std::string::npos);
        EXPECT_EQ(runs.run("broken", false, Break::kill_all, 30), 137);
        EXPECT_EQ(runs.run("broken", true, Break::kill_all, 170), 137);
        EXPECT_EQ(runs.run("broken", true), 0);
        runs.expect_same("broken", "whole");
    }
}

TEST(ResumedRuns, of_a_map_that_another_odometry_drives_at_a_lower_rate) {
    const std::string ini =
        "checkpoint_items = 1\nmodules = lidar_odometry lidar_mapping\n[lidar_mapping]\nevery_sweeps = "
        "3\nodometry = ";
    for (const std::string odometry : {"lidar_odometry", "wheels"}) {
        const BrokenRuns runs(test::short_street_log(), ini + odometry + "\n");
        ASSERT_EQ(runs.run("whole", false), 0);
        EXPECT_EQ(runs.run("broken", false, Break::kill_all, 44), 137);  // while a sweep waits for the wheels
        EXPECT_EQ(runs.run("broken", true), 0);
        runs.expect_same("broken", "whole");
    }
}

TEST(ResumedRuns, of_one_that_is_localised_in_a_finished_cloud) {
    // The fourth sweep on is known; what was searched for before it is in the checkpoint too.
    const BrokenRuns runs(test::placed_street_log(),
                          "checkpoint_items = 4\nmodules = cloud_localisation\n[cloud_localisation]\nmap = " +
                              test::placed_street_map() + "\n");
    ASSERT_EQ(runs.run("whole", false), 0);
    for (const std::uint64_t at : {6U, 60U}) {
        EXPECT_EQ(runs.run("broken", false, Break::kill_all, at), 137);
        EXPECT_EQ(runs.run("broken", true), 0);
        runs.expect_same("broken", "whole");
        std::filesystem::remove_all(runs.path("broken"));
    }
}

TEST(ResumedRuns, of_a_drive_among_trees) {
    const BrokenRuns runs(test::grove_log(), "checkpoint_items = 10\nmodules = landmark_odometry\n");
    ASSERT_EQ(runs.run("whole", false), 0);
    for (const std::uint64_t at : {11U, 150U}) {
        EXPECT_EQ(runs.run("broken", false, Break::kill_all, at), 137);
        EXPECT_EQ(runs.run("broken", true), 0);
        runs.expect_same("broken", "whole");
        std::filesystem::remove_all(runs.path("broken"));
    }
}
