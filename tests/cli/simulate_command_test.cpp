/// loopline simulate as a user runs it: the log, the truth beside it, equal bytes, and every way of being
/// wrong.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>
#include <map>
#include <sstream>

#include "api/stamp.h"
#include "output/tum.h"
#include "pipeline/log_source.h"
#include "support/built_files.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::test;

namespace {

const char* const corridor = R"([simulation]
seed = 5
sensors = commands wheels horizontal_laser survey_laser
[world]
wall_m = -2 -1  8 -1  8 6  6 6  6 1  -2 1  -2 -1
door_m = 2 1  3 1  0.3
point_m = 1 6 1
point_m = 2 2 1.3
[route]
waypoint_m = 0 0
waypoint_m = 7 0
waypoint_m = 7 3
[vehicle]
straight_mps = 0.5
turn_outer_mps = 0.3
turn_inner_mps = 0
[horizontal_laser]
rate_hz = 10
[survey_laser]
rate_hz = 5
sweep_s = 4
)";

const char* const cart = R"([simulation]
seed = 5
sensors = wheels imu horizontal_laser
[world]
sigma_tilt_deg = 0.2
partition_m = -3 2  9 2  0.15
clutter_m = -3 -4  9 -1  4
[route]
drive = pushed
waypoint_m = 0 0
waypoint_m = 6 0
[cart]
standstill_s = 5
[imu]
x_m = 0.1
[horizontal_laser]
rate_hz = 10
)";

class Simulate : public ::testing::Test {
 protected:
    ProgramResult simulate(const std::string& scenario, const std::string& out,
                           const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{"simulate", scenario, "--out", (folder / out).string()};
        words.insert(words.end(), more.begin(), more.end());
        return run_loopline(words);
    }
    std::string scenario() { return folder.write("corridor.ini", corridor); }

    TemporaryFolder folder;
};

struct WallRow {
    Eigen::Vector2d from_m, to_m;
    double bottom_m, top_m;
};

struct TruthFile {
    std::map<int, Eigen::Vector2d> points;
    std::vector<WallRow> walls;
    std::vector<double> levels_m;
};

TruthFile read_truth(const std::filesystem::path& file) {
    TruthFile truth;
    std::istringstream lines(file_text(file));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "kind,number,x_m,y_m,x2_m,y2_m,bottom_m,top_m");
    while (std::getline(lines, line)) {
        const auto words = split_words(line, ",");
        std::vector<double> v;
        for (std::size_t i = 2; i < words.size(); ++i) v.push_back(std::stod(words[i]));
        if (words[0] == "point") truth.points[std::stoi(words[1])] = {v[0], v[1]};
        if (words[0] == "wall") truth.walls.push_back({{v[0], v[1]}, {v[2], v[3]}, v[4], v[5]});
        if (words[0] == "level") truth.levels_m.push_back(v[0]);
    }
    return truth;
}

double distance_to_truth_m(const TruthFile& truth, const Eigen::Vector3d& p) {
    double least_m = 1e9;
    for (const double level_m : truth.levels_m) least_m = std::min(least_m, std::abs(p.z() - level_m));
    for (const WallRow& wall : truth.walls) {
        const Eigen::Vector2d way_m = wall.to_m - wall.from_m, to_m = p.head<2>() - wall.from_m;
        const double part = std::clamp(to_m.dot(way_m) / way_m.squaredNorm(), 0.0, 1.0);
        const double off_m = (to_m - part * way_m).norm();
        const double over_m = std::max({0.0, p.z() - wall.top_m, wall.bottom_m - p.z()});
        least_m = std::min(least_m, std::hypot(off_m, over_m));
    }
    return least_m;
}

/// The observations of a class and label, as our own reader gives them.
template <class Observation>
std::vector<std::shared_ptr<const Observation>> all_of(const std::string& rawlog, const std::string& label) {
    std::vector<std::shared_ptr<const Observation>> found;
    LogSource source({rawlog});
    for (StreamItem item; source.next(item);)
        if (const auto o = std::dynamic_pointer_cast<const Observation>(item.observation);
            o && (label.empty() || o->sensorLabel == label))
            found.push_back(o);
    return found;
}

using Scan = mrpt::obs::CObservation2DRangeScan;

}  // namespace

TEST_F(Simulate, log_and_truth_agree) {
    const auto result = simulate(scenario(), "a.rawlog", {"--set", "horizontal_laser.sweep_part=0"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    const std::string rawlog = (folder / "a.rawlog").string();
    const TruthFile truth = read_truth(folder / "a.truth.csv");
    ASSERT_EQ(truth.points.size(), 2u);
    EXPECT_EQ(truth.points.at(2), Eigen::Vector2d(2, 1.3));
    ASSERT_EQ(truth.levels_m.size(), 2u);

    const auto scans = all_of<Scan>(rawlog, "horizontal_laser");
    const auto path = read_tum(folder / "a.truth.tum");
    ASSERT_EQ(scans.size(), path.size());
    ASSERT_GT(scans.size(), 150u);
    EXPECT_EQ(path[0].T_map_base.translation_m, Eigen::Vector3d(0, 0, 0));
    std::size_t points = 0, off = 0;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        ASSERT_EQ(*stamp_from_mrpt(scans[i]->timestamp), path[i].stamp_ns);
        for (std::size_t k = 0; k < scans[i]->getScanSize(); ++k) {
            if (!scans[i]->getScanRangeValidity(k)) continue;
            const double a = scans[i]->getScanAngle(k), r = scans[i]->getScanRange(k);
            const auto& m = scans[i]->sensorPose;
            const Eigen::Vector3d p_map =
                path[i].T_map_base * Eigen::Vector3d(m.x() + r * std::cos(a), m.y() + r * std::sin(a), m.z());
            ++points;
            off += distance_to_truth_m(truth, p_map) > 0.05;  // five times the noise
        }
    }
    EXPECT_GT(points, 20000u);
    EXPECT_LT(static_cast<double>(off) / static_cast<double>(points), 0.01) << "mixed pixels are rare";
}

TEST_F(Simulate, survey_scans_carry_the_tilt_of_their_first_beam) {
    ASSERT_EQ(simulate(scenario(), "a.rawlog",
                       {"--set", "survey_laser.sigma_range_m=0", "--set", "survey_laser.resolution_m=0",
                        "--set", "survey_laser.beam_width_deg=0", "--set", "survey_laser.sweep_part=0",
                        "--set", "horizontal_laser.rate_hz=5"})
                  .exit_code,
              0);
    const TruthFile truth = read_truth(folder / "a.truth.csv");
    const auto path = read_tum(folder / "a.truth.tum");
    const auto scans = all_of<Scan>((folder / "a.rawlog").string(), "survey_laser");
    ASSERT_EQ(scans.size(), path.size()) << "the same rate, so the same stamps";
    double lowest = 9, highest = -9, worst_m = 0;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        const auto& s = *scans[i];
        ASSERT_EQ(*stamp_from_mrpt(s.timestamp), path[i].stamp_ns);
        lowest = std::min(lowest, s.sensorPose.pitch());
        highest = std::max(highest, s.sensorPose.pitch());
        for (std::size_t k = 0; k < s.getScanSize(); ++k) {
            if (!s.getScanRangeValidity(k)) continue;
            const double a = s.getScanAngle(k), r = s.getScanRange(k);
            double x = 0, y = 0, z = 0;
            s.sensorPose.composePoint(r * std::cos(a), r * std::sin(a), 0, x, y, z);
            worst_m =
                std::max(worst_m, distance_to_truth_m(truth, path[i].T_map_base * Eigen::Vector3d(x, y, z)));
        }
    }
    EXPECT_LT(worst_m, 1e-4) << "float ranges";
    EXPECT_NEAR(lowest * 180 / M_PI, -60, 3) << "pitch is positive downwards";
    EXPECT_NEAR(highest * 180 / M_PI, 30, 3);
}

TEST_F(Simulate, wheels_and_commands_tell_of_the_turn) {
    ASSERT_EQ(simulate(scenario(), "a.rawlog").exit_code, 0);
    const std::string rawlog = (folder / "a.rawlog").string();
    const auto wheels = all_of<mrpt::obs::CObservationOdometry>(rawlog, "wheels");
    ASSERT_GT(wheels.size(), 300u);
    EXPECT_EQ(wheels[0]->odometry.x(), 0);
    EXPECT_TRUE(wheels[0]->hasEncodersInfo && wheels[0]->hasVelocities);
    EXPECT_NEAR(wheels[100]->velocityLocal.vx, 0.5, 0.02);
    const auto commands = all_of<mrpt::obs::CObservationComment>(rawlog, "");
    ASSERT_GE(commands.size(), 3u);
    EXPECT_EQ(commands[0]->text, "straight");
    EXPECT_TRUE(
        std::any_of(commands.begin(), commands.end(), [](const auto& c) { return c->text == "left"; }));
}

TEST_F(Simulate, a_seed_gives_its_bytes_and_another_gives_others) {
    ASSERT_EQ(simulate(scenario(), "a.rawlog").exit_code, 0);
    ASSERT_EQ(simulate(scenario(), "b.rawlog").exit_code, 0);
    ASSERT_EQ(simulate(scenario(), "c.rawlog", {"--set", "simulation.seed=6"}).exit_code, 0);
    for (const char* extension : {".rawlog", ".truth.tum", ".truth.csv", ".scenario.ini"})
        EXPECT_EQ(file_text(folder / (std::string("a") + extension)),
                  file_text(folder / (std::string("b") + extension)))
            << extension;
    EXPECT_NE(file_text(folder / "a.rawlog"), file_text(folder / "c.rawlog"));
    EXPECT_NE(file_text(folder / "a.truth.tum"), file_text(folder / "c.truth.tum"));
    EXPECT_EQ(file_text(folder / "a.truth.csv"), file_text(folder / "c.truth.csv"));
    // The effective scenario makes the same log again.
    ASSERT_EQ(simulate((folder / "c.scenario.ini").string(), "d.rawlog").exit_code, 0);
    EXPECT_EQ(file_text(folder / "c.rawlog"), file_text(folder / "d.rawlog"));
    EXPECT_EQ(file_text(folder / "c.scenario.ini"), file_text(folder / "d.scenario.ini"));
}

TEST_F(Simulate, a_sensor_sees_the_same_whatever_the_others_do) {
    ASSERT_EQ(simulate(scenario(), "a.rawlog").exit_code, 0);
    ASSERT_EQ(simulate(scenario(), "b.rawlog", {"--set", "simulation.sensors=horizontal_laser"}).exit_code,
              0);
    const auto a = all_of<Scan>((folder / "a.rawlog").string(), "horizontal_laser");
    const auto b = all_of<Scan>((folder / "b.rawlog").string(), "horizontal_laser");
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t k = 0; k < a[i]->getScanSize(); ++k)
            ASSERT_EQ(a[i]->getScanRange(k), b[i]->getScanRange(k));
}

TEST_F(Simulate, what_is_wrong_is_told_with_its_place_and_nothing_is_written) {
    const auto wrong = [&](const std::string& text, const std::vector<std::string>& sentences,
                           const std::vector<std::string>& more = {}) {
        const auto result = simulate(folder.write("wrong.ini", text), "w.rawlog", more);
        EXPECT_EQ(result.exit_code, 2) << text;
        for (const auto& sentence : sentences)
            EXPECT_NE(result.err.find(sentence), std::string::npos) << sentence << "\n--\n" << result.err;
        for (const char* extension :
             {".rawlog", ".truth.tum", ".truth.csv", ".scenario.ini", ".rawlog.partial"})
            EXPECT_FALSE(std::filesystem::exists(folder / (std::string("w") + extension)));
    };
    wrong("[simulation]\nsede = 2\n[world]\nwall_m = 0 0 1\nwall_m = 0 0 1 x\n[wold]\n",
          {"wrong.ini:2: [simulation] sede is not a key of this section; did you mean \"seed\"?",
           "wrong.ini:4: [world] wall_m has 3 numbers (needed: x y x y ...)",
           "wrong.ini:5: [world] wall_m holds \"x\", which is not a number",
           "wrong.ini:6: there is no section [wold]; did you mean \"world\"?"});
    wrong(
        "[world]\nwall_m = 0 0 1 0\ndoor_m = 0 0 1 0 1\ndoor_m = 0 0 1 4 1\npoint_m = 1 3 "
        "3\n[route]\nwaypoint_m = 0 0\n",
        {"wrong.ini:4: [world] door_m does not lie on one wall",
         "wrong.ini:5: [world] point_m is not the corner", "wrong.ini:6: [route] needs two waypoint_m"});
    wrong(std::string(corridor) + "min_range_m = 50\n",
          {"wrong.ini:19: [survey_laser] min_range_m is not below"});
    wrong(corridor, {"--set simulation.sensors=lidar: [simulation] sensors names \"lidar\", which is none"},
          {"--set", "simulation.sensors=lidar"});
    wrong(corridor, {"the vehicle does not arrive within 3 s"}, {"--set", "simulation.longest_s=3"});
    wrong(
        "[route]\ndrive = pushed\nlaps = 2\nwaypoint_m = 0 0\nwaypoint_m = 9 0\nwaypoint_m = 1 0.5\n"
        "[world]\npartition_m = 0 0 0 0 1\nclutter_m = 0 0 1 1 2.5\n",
        {"wrong.ini:2: [route] drive = pushed can't follow a route that turns back by more than 150 degrees",
         "wrong.ini:3: [route] laps needs a last waypoint_m that is the first one",
         "wrong.ini:8: [world] partition_m is not longer and thicker than 1 mm",
         "wrong.ini:9: [world] clutter_m has a number of pieces that is not whole"});
    wrong("[run]\nrawlog = x\n", {"wrong.ini:1: a scenario has no section [run]"});
    const auto run = run_loopline({"run", scenario(), "--out", (folder / "run").string()});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find("corridor.ini:1: an experiment has no section [simulation]; this is a scenario"),
              std::string::npos)
        << run.err;
    const auto missing = simulate((folder / "none.ini").string(), "w.rawlog");
    EXPECT_EQ(missing.exit_code, 2);
    EXPECT_NE(missing.err.find("there is no such file"), std::string::npos);
    const auto nowhere = run_loopline({"simulate", scenario(), "--out", "/nowhere/w.rawlog"});
    EXPECT_EQ(nowhere.exit_code, 2);
    EXPECT_NE(nowhere.err.find("can't write"), std::string::npos);
}

TEST_F(Simulate, a_cart_carries_an_imu_and_the_truth_has_its_biases) {
    const std::string file = folder.write("cart.ini", cart);
    ASSERT_EQ(simulate(file, "a.rawlog").exit_code, 0);
    ASSERT_EQ(simulate(file, "b.rawlog").exit_code, 0);
    for (const char* extension : {".rawlog", ".truth.tum", ".truth.csv"})
        EXPECT_EQ(file_text(folder / (std::string("a") + extension)),
                  file_text(folder / (std::string("b") + extension)))
            << extension;
    ASSERT_EQ(simulate(file, "alone.rawlog", {"--set", "simulation.sensors=imu"}).exit_code, 0);
    const auto a = all_of<mrpt::obs::CObservationIMU>((folder / "a.rawlog").string(), "imu");
    const auto alone = all_of<mrpt::obs::CObservationIMU>((folder / "alone.rawlog").string(), "imu");
    ASSERT_EQ(a.size(), alone.size());
    ASSERT_GT(a.size(), 2000u);
    Eigen::Vector3d mean_radps = Eigen::Vector3d::Zero();
    constexpr int standing = 900;  // of 5 s at 200 Hz
    for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_EQ(a[i]->rawMeasurements, alone[i]->rawMeasurements) << "whatever the others do";
        EXPECT_EQ(a[i]->sensorPose.x(), 0.1);
        if (i < standing)
            mean_radps += Eigen::Vector3d(a[i]->get(mrpt::obs::IMU_WX), a[i]->get(mrpt::obs::IMU_WY),
                                          a[i]->get(mrpt::obs::IMU_WZ)) /
                          standing;
    }
    std::istringstream lines(file_text(folder / "a.truth.csv"));
    int biases = 0;
    for (std::string line; std::getline(lines, line);) {
        const auto words = split_words(line, ",");
        if (words[0] != "imu_bias") continue;
        ASSERT_EQ(words.size(), 8u);
        EXPECT_EQ(std::stoi(words[1]), biases++);
        for (int axis = 0; biases <= 4 && axis < 3; ++axis)
            EXPECT_NEAR(std::stod(words[static_cast<std::size_t>(2 + axis)]), mean_radps[axis],
                        0.02 * M_PI / 180);
    }
    EXPECT_NEAR(biases, static_cast<double>(a.size()) / 200, 1);
}

TEST_F(Simulate, interrupted_it_leaves_nothing) {
    const auto result =
        run_program({"timeout", "--preserve-status", "-s", "INT", "1", test::loopline_program(), "simulate",
                     test::source_folder() + "/datasets/ring_corridor.ini", "--out",
                     (folder / "w.rawlog").string(), "--set", "horizontal_laser.beams=5000"});
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_NE(result.err.find("interrupted; nothing was written"), std::string::npos) << result.err;
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST_F(Simulate, every_dataset_is_right) {
    for (const char* name : {"ring_corridor", "ring_corridor_bare", "office", "campus_lines", "cart_loops",
                             "cart_corridor", "cart_twin_rooms", "road_loop", "straight_street",
                             "ramp_gallery", "open_field", "tunnel", "urban_canyon"}) {
        const std::string file = test::source_folder() + "/datasets/" + name + ".ini";
        // A moment is enough: that the vehicle does not arrive is said after everything else was found good.
        const auto result = simulate(file, "w.rawlog", {"--set", "simulation.longest_s=1"});
        EXPECT_NE(result.err.find("the vehicle does not arrive"), std::string::npos) << result.err;
    }
}
