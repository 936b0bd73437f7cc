/// loopline simulate with a spinning lidar as a user runs it.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationRotatingScan.h>

#include "lidar/observation_scan.h"
#include "output/tum.h"
#include "pipeline/log_source.h"
#include "simulation/town/recorded_path.h"
#include "support/run_program.h"
#include "support/shared_data.h"
#include "support/simulated_scene.h"

using namespace loopline;
using namespace loopline::test;

namespace {

const char* const short_street = R"([simulation]
seed = 3
sensors = wheels imu spinning_lidar
[world]
generator = town
[route]
drive = pushed
waypoint_m = 0 0
waypoint_m = 12 0
[cart]
speed_mps = 8
standstill_s = 1
end_standstill_s = 1
[terrain]
sigma_slope_deg = 2
[spinning_lidar]
beams = 16
columns = 450
)";

class SimulateTown : public ::testing::Test {
 protected:
    ProgramResult simulate(const std::string& ini, const std::string& out,
                           const std::vector<std::string>& set = {}) {
        std::vector<std::string> words{"simulate", ini, "--out", (folder / out).string()};
        for (const auto& assignment : set) words.insert(words.end(), {"--set", assignment});
        return run_loopline(words);
    }
    TemporaryFolder folder;
};

std::vector<lidar::SpinningScan> sweeps_of(const std::string& rawlog) {
    std::vector<lidar::SpinningScan> scans;
    lidar::SpinningScanReader reader;
    lidar::SpinningScan scan;
    LogSource source({rawlog});
    for (StreamItem item; source.next(item);)
        if (reader.read(*item.observation, scan)) scans.push_back(scan);
    return scans;
}

}  // namespace

TEST_F(SimulateTown, scans_have_their_truth_and_a_seed_its_bytes) {
    const std::string scenario = folder.write("street.ini", short_street);
    const auto result = simulate(scenario, "a.rawlog");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto scans = sweeps_of((folder / "a.rawlog").string());
    const auto path = read_tum(folder / "a.truth.tum");
    ASSERT_EQ(scans.size(), path.size());
    ASSERT_GT(scans.size(), 40u);
    double most_tilt_rad = 0;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        EXPECT_EQ(scans[i].stamp_ns, path[i].stamp_ns);
        EXPECT_EQ(scans[i].rings(), 16u);
        EXPECT_GT(scans[i].points.size(), 3000u);
        most_tilt_rad =
            std::max(most_tilt_rad, std::acos((path[i].T_map_base.rotation * Eigen::Vector3d::UnitZ()).z()));
    }
    EXPECT_GT(most_tilt_rad, 0.002) << "the ground is not level";
    ASSERT_EQ(simulate(scenario, "b.rawlog").exit_code, 0);
    ASSERT_EQ(simulate(scenario, "c.rawlog", {"simulation.seed=4"}).exit_code, 0);
    EXPECT_EQ(file_text(folder / "a.rawlog"), file_text(folder / "b.rawlog"));
    EXPECT_NE(file_text(folder / "a.rawlog"), file_text(folder / "c.rawlog"));
}

TEST_F(SimulateTown, a_log_that_nothing_scans_has_a_truth_to_be_compared_with) {
    const std::string scenario = folder.write("street.ini", short_street);
    const std::string log = (folder / "bare.rawlog").string();
    ASSERT_EQ(simulate(scenario, "bare.rawlog", {"simulation.sensors=gnss wheels"}).exit_code, 0);
    EXPECT_GT(read_tum(folder / "bare.truth.tum").size(), 50U);
    const std::string ini = folder.write("bare.ini",
                                         "[run]\nrawlog = x\nmodules = fusion\ntrajectory = fusion\n"
                                         "[fusion]\nmotion =\nwheels = wheels\n");
    const auto run =
        run_loopline({"run", ini, "--rawlog", log, "--out", (folder / "run").string(), "--quiet"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_NE(file_text(folder / "run/metrics.json").find("\"earth_rmse_m\""), std::string::npos);
}

TEST_F(SimulateTown, what_else_is_on_board_does_not_change_a_sweep) {
    const std::string scenario = folder.write("street.ini", short_street);
    ASSERT_EQ(simulate(scenario, "all.rawlog", {"simulation.sensors=spinning_lidar gnss wheels"}).exit_code,
              0);
    ASSERT_EQ(simulate(scenario, "alone.rawlog", {"simulation.sensors=spinning_lidar"}).exit_code, 0);
    EXPECT_EQ(file_text(folder / "all.truth.tum"), file_text(folder / "alone.truth.tum"));
    using Sweep = mrpt::obs::CObservationRotatingScan;
    std::vector<Sweep::Ptr> sweeps[2];
    std::size_t late = 0, fixes = 0, backwards = 0;
    StampNs newest_ns = 0;
    for (const std::size_t i : {0, 1}) {
        LogSource source({(folder / (i == 0 ? "all.rawlog" : "alone.rawlog")).string()});
        for (StreamItem item; source.next(item);) {
            if (const auto sweep = std::dynamic_pointer_cast<const Sweep>(item.observation))
                sweeps[i].push_back(std::make_shared<Sweep>(*sweep));
            const StampNs stamp_ns = *stamp_from_mrpt(item.observation->timestamp);
            if (std::dynamic_pointer_cast<const mrpt::obs::CObservationGPS>(item.observation)) {
                ++fixes;
                late += stamp_ns < newest_ns;
            } else {
                backwards += i == 0 && stamp_ns < newest_ns;
                newest_ns = std::max(newest_ns, stamp_ns);
            }
        }
    }
    EXPECT_GT(fixes, 15u);
    EXPECT_EQ(late, fixes) << "behind what was measured after them";
    EXPECT_EQ(backwards, 0u);
    ASSERT_EQ(sweeps[0].size(), sweeps[1].size());
    for (std::size_t i = 0; i < sweeps[0].size(); ++i) {
        ASSERT_EQ(sweeps[0][i]->timestamp, sweeps[1][i]->timestamp);
        ASSERT_EQ(sweeps[0][i]->rangeImage, sweeps[1][i]->rangeImage);
    }
    std::istringstream lines(file_text(folder / "all.truth.csv"));
    std::size_t rows = 0;
    for (std::string line; std::getline(lines, line);) rows += line.rfind("gnss,", 0) == 0;
    EXPECT_EQ(rows, fixes);
}

TEST_F(SimulateTown, what_cannot_be_is_said) {
    const std::string scenario = folder.write("street.ini", short_street);
    auto result = simulate(scenario, "a.rawlog", {"spinning_lidar.beams=40"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("beams is none of 16, 32 and 64"), std::string::npos) << result.err;
    result = simulate(scenario, "a.rawlog", {"gnss.state_m=10 20 3"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("last number is none of 0 (no fix), 1 (single), 4 (fixed) and 5 (float)"),
              std::string::npos)
        << result.err;
    result = simulate(scenario, "a.rawlog", {"town.least_storeys=9"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("least_storeys is above storeys"), std::string::npos) << result.err;
    result = simulate(scenario, "a.rawlog", {"simulation.sensors=horizontal_laser"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("sees walls and nothing of a town"), std::string::npos) << result.err;
    result = simulate(scenario, "a.rawlog", {"route.drive=steered"});
    EXPECT_EQ(result.exit_code, 2);
    result = simulate(scenario, "a.rawlog", {"path.sequence=99", "path.folder=" + folder.path().string()});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("remove waypoint_m"), std::string::npos) << result.err;
    result = simulate(dataset("along_kitti.ini"), "a.rawlog",
                      {"path.sequence=99", "path.folder=" + folder.path().string()});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("99.txt"), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.rawlog"));
}

TEST_F(SimulateTown, a_plan_of_walls_is_seen_too) {
    const std::string scenario = folder.write("room.ini", R"([simulation]
sensors = spinning_lidar
[world]
wall_m = -5 -4  8 -4  8 4  -5 4  -5 -4
[route]
waypoint_m = 0 0
waypoint_m = 0.5 0
[vehicle]
straight_mps = 0.5
[spinning_lidar]
beams = 16
columns = 90
z_m = 1
)");
    const auto result = simulate(scenario, "a.rawlog");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto scans = sweeps_of((folder / "a.rawlog").string());
    ASSERT_GT(scans.size(), 5u);
    for (const auto& p : scans[0].points) {
        const Eigen::Vector3d q = Eigen::Vector3d(p.x_m, p.y_m, p.z_m + 1);
        ASSERT_TRUE(q.x() > -5.2 && q.x() < 8.2 && std::abs(q.y()) < 4.2 && q.z() > -0.2 && q.z() < 3);
    }
}

TEST_F(SimulateTown, the_way_along_kitti_is_kittis) {
    NEEDS_SHARED_DATA("kitti_odometry_gt_poses/07.txt");
    const std::string file = (shared_data() / "kitti_odometry_gt_poses/07.txt").string();
    const auto poses = simulation::read_kitti_poses(file);
    const std::vector<std::string> set{"path.folder=" + (shared_data() / "kitti_odometry_gt_poses").string(),
                                       "spinning_lidar.columns=60", "town.ground_cell_m=8",
                                       "town.reach_m=60"};
    ASSERT_EQ(simulate(dataset("along_kitti.ini"), "a.rawlog", set).exit_code, 0);
    auto exact = set;
    exact.insert(exact.end(), {"path.level_revisits=false", "path.poses=200"});
    ASSERT_EQ(simulate(dataset("along_kitti.ini"), "b.rawlog", exact).exit_code, 0);
    const auto levelled = read_tum(folder / "a.truth.tum"), untouched = read_tum(folder / "b.truth.tum");
    ASSERT_EQ(levelled.size(), poses.size());
    ASSERT_EQ(untouched.size(), 200u);
    EXPECT_EQ(sweeps_of((folder / "a.rawlog").string()).size(), poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const Eigen::Vector3d off_m = levelled[i].T_map_base.translation_m - poses[i].translation_m;
        ASSERT_NEAR(off_m.head<2>().norm(), 0, 1e-6);
        ASSERT_LT(std::abs(off_m.z()), 0.3);
        ASSERT_LT(levelled[i].T_map_base.rotation.angularDistance(poses[i].rotation), 1e-6);
        if (i >= untouched.size()) continue;
        ASSERT_NEAR((untouched[i].T_map_base.translation_m - poses[i].translation_m).norm(), 0, 1e-6);
    }
}

TEST_F(SimulateTown, the_ground_passes_below_kittis_camera) {
    NEEDS_SHARED_DATA("kitti_odometry_gt_poses/02.txt");
    for (const char* sequence : {"02", "07"}) {
        const auto scene =
            scene_of(dataset("along_kitti.ini"),
                     {"path.folder=" + (shared_data() / "kitti_odometry_gt_poses").string(),
                      std::string("path.sequence=") + sequence, "town.built=0", "town.trees_per_km=0",
                      "town.ground_cell_m=50", "traffic.oncoming_s=0", "traffic.ahead=0"});
        double squares_m2 = 0, most_m = 0, count = 0;
        for (StampNs time_ns = 0; time_ns <= scene->duration_ns(); time_ns += 500'000'000) {
            const Eigen::Vector3d camera_m = scene->drive.motion.pose_at(time_ns).translation_m;
            const double off_m = camera_m.z() - scene->landscape->ground->height_m(camera_m.head<2>()) - 1.65;
            squares_m2 += off_m * off_m;
            most_m = std::max(most_m, std::abs(off_m));
            ++count;
        }
        EXPECT_LT(std::sqrt(squares_m2 / count), 0.04) << sequence;
        EXPECT_LT(most_m, 0.25) << sequence;
    }
}
