/// The survey cloud: a room of known walls, measured beam by beam from a moving, turning vehicle with a
/// tilting laser.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>

#include "maps_test_support.h"
#include "survey/survey_module.h"
#include "survey/sweep_fusion.h"

using namespace loopline;
using namespace loopline::survey;

namespace {

constexpr StampNs scan_period_ns = 64'000'000;
constexpr double scan_duration_s = 0.05;
constexpr int scans = 60;

/// A room: x from -4 to 6, y from -3 to 5, z from 0 to 2.5.
const Eigen::Vector3d room_low_m(-4, -3, 0), room_high_m(6, 5, 2.5);

double range_in_room_m(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
    double range_m = INFINITY;
    for (int i = 0; i < 3; ++i) {
        if (direction[i] > 0) range_m = std::min(range_m, (room_high_m[i] - from[i]) / direction[i]);
        if (direction[i] < 0) range_m = std::min(range_m, (room_low_m[i] - from[i]) / direction[i]);
    }
    return range_m;
}

double distance_to_room_m(const Eigen::Vector3d& p) {
    double distance_m = INFINITY;
    for (int i = 0; i < 3; ++i)
        distance_m = std::min({distance_m, std::abs(p[i] - room_low_m[i]), std::abs(p[i] - room_high_m[i])});
    return distance_m;
}

/// Constant twist: an arc at 0.5 m/s and 0.6 rad/s.
Pose3 true_pose(StampNs time_ns) {
    return exp_se3({{0.5 * 1e-9 * double(time_ns), 0, 0}, {0, 0, 0.6 * 1e-9 * double(time_ns)}});
}

/// Tilts about the axis of a servo, 10 cm behind the sensor.
Pose3 true_mount(StampNs time_ns) {
    const double tilt_rad = -0.4 + 0.5 * 1e-9 * double(time_ns);
    const Pose3 servo({0.2, 0, 1.1},
                      Eigen::Quaterniond(Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitY())));
    return servo * Pose3({0.1, 0, 0}, Eigen::Quaterniond::Identity());
}

mrpt::poses::CPose3D mrpt_pose(const Pose3& pose) {
    mrpt::math::CMatrixDouble33 rotation;
    rotation.asEigen() = pose.rotation.toRotationMatrix();
    mrpt::poses::CPose3D result;
    result.setRotationMatrix(rotation);
    result.x(pose.translation_m.x());
    result.y(pose.translation_m.y());
    result.z(pose.translation_m.z());
    return result;
}

/// Every beam is cast from where the sensor is at its time; the first in time is the first in the scan.
mrpt::obs::CObservation2DRangeScan::Ptr measured_scan(StampNs start_ns, bool counter_clockwise) {
    constexpr std::size_t beams = 91;
    std::vector<float> ranges;
    for (std::size_t beam = 0; beam < beams; ++beam) {
        const double along = double(beam) / double(beams - 1);
        const auto time_ns = start_ns + static_cast<StampNs>(std::llround(1e9 * scan_duration_s * along));
        const double angle = M_PI * (along - 0.5) * (counter_clockwise ? 1 : -1);
        const Pose3 T_map_sensor = true_pose(time_ns) * true_mount(time_ns);
        ranges.push_back(static_cast<float>(
            range_in_room_m(T_map_sensor.translation_m,
                            T_map_sensor.rotation * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0))));
    }
    auto scan = maps_test::scan_of(ranges, M_PI, mrpt_pose(true_mount(start_ns)), counter_clockwise);
    scan->sensorLabel = "survey_laser";
    return scan;
}

Trajectory true_path() {
    Trajectory path;
    for (int i = 0; i <= 2 * scans; ++i) {
        const StampNs time_ns = scan_period_ns / 2 * i;
        path.append(static_cast<std::uint64_t>(i), time_ns, true_pose(time_ns), Matrix6d::Zero());
    }
    return path;
}

Results survey_of_room(bool counter_clockwise, const std::vector<std::pair<std::string, std::string>>& keys) {
    const Trajectory path = true_path();
    SurveyMapBuilder builder;
    for (const auto& [key, value] : keys) maps_test::set(builder, key, value);
    builder.start({}, path);
    for (int i = 0; i < scans; ++i)
        builder.insert({static_cast<std::uint64_t>(2 * i), scan_period_ns * i,
                        measured_scan(scan_period_ns * i, counter_clockwise)});
    Results results;
    builder.finish(results);
    return results;
}

double worst_distance_m(const Results& results) {
    const auto cloud = maps_test::only_map<mrpt::maps::CSimplePointsMap>(results);
    double worst_m = 0;
    for (std::size_t i = 0; i < cloud->size(); ++i) {
        float x = 0, y = 0, z = 0;
        cloud->getPoint(i, x, y, z);
        worst_m = std::max(worst_m, distance_to_room_m({x, y, z}));
    }
    return worst_m;
}

std::int64_t count(const Results& results, const char* key) {
    return std::get<std::int64_t>(results.metrics.at(key));
}

}  // namespace

TEST(SurveyFusion, a_room_seen_from_a_moving_turning_tilting_laser_lies_on_its_walls) {
    for (const bool counter_clockwise : {true, false}) {
        const Results results = survey_of_room(counter_clockwise, {{"scan_duration_s", "0.05"}});
        EXPECT_EQ(count(results, "survey_points"), 60 * 91);
        EXPECT_LT(worst_distance_m(results), 1e-4) << counter_clockwise;
    }
}

TEST(SurveyFusion, beams_at_the_scan_s_stamp_would_miss_the_walls) {
    EXPECT_GT(worst_distance_m(survey_of_room(true, {{"scan_duration_s", "0"}})), 0.05);
}

TEST(SurveyFusion, every_beam_is_accounted_for) {
    const Trajectory path = true_path();
    SurveyMapBuilder builder;
    maps_test::set(builder, "min_range_m", "1");
    maps_test::set(builder, "max_range_m", "10");
    builder.start({}, path);
    auto scan = maps_test::scan_of({2, 0, 0.5f, 20, 3}, M_PI);
    builder.insert({0, 0, scan});
    builder.insert({100, scan_period_ns * scans + 1, scan});  // after the last pose
    Results results;
    builder.finish(results);
    EXPECT_EQ(count(results, "survey_scans"), 2);
    EXPECT_EQ(count(results, "survey_beams"), 10);
    EXPECT_EQ(count(results, "survey_beams_without_return"), 2);
    EXPECT_EQ(count(results, "survey_beams_out_of_range"), 4);
    EXPECT_EQ(count(results, "survey_beams_without_pose"), 2);
    EXPECT_EQ(count(results, "survey_points"), 2);
    EXPECT_TRUE(results.maps.at(0).survey);
}

TEST(SurveyFusion, other_lasers_thinning_and_the_limit_of_points) {
    const Results none = survey_of_room(true, {{"sensors", "another"}});
    EXPECT_EQ(count(none, "survey_points"), 0);
    const Results thinned = survey_of_room(true, {{"scan_duration_s", "0.05"}, {"spacing_m", "0.25"}});
    const auto kept = count(thinned, "survey_points");
    EXPECT_GT(kept, 500);
    EXPECT_EQ(kept + count(thinned, "survey_points_thinned"), 60 * 91);
    const Results few = survey_of_room(true, {{"max_points", "100"}});
    EXPECT_EQ(count(few, "survey_points"), 100);
    EXPECT_EQ(count(few, "survey_points_over_limit"), 60 * 91 - 100);
}

TEST(SurveyFusion, a_mount_without_neighbours_in_time_stands_still) {
    TimedScan scan, next;
    scan.T_base_sensor = true_mount(0);
    next.first_beam_ns = 10'000'000'000;
    next.T_base_sensor = true_mount(scan_period_ns);
    EXPECT_EQ(mount_motion(nullptr, scan, &next, 0.5).at(1'000'000'000).translation_m,
              scan.T_base_sensor.translation_m);
    EXPECT_EQ(mount_motion(nullptr, scan, nullptr, 0.5).at(1'000'000'000).translation_m,
              scan.T_base_sensor.translation_m);
    // The last scan goes on as the one before it moved.
    next.first_beam_ns = scan_period_ns;
    const Pose3 expected = true_mount(scan_period_ns * 3 / 2);
    const Pose3 after = mount_motion(&scan, next, nullptr, 0.5).at(scan_period_ns * 3 / 2);
    EXPECT_LT((after.translation_m - expected.translation_m).norm(), 1e-12);
    EXPECT_LT(after.rotation.angularDistance(expected.rotation), 1e-9);
}
