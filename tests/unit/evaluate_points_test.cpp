/// Feature points and survey clouds against the truth.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>
#include <random>

#include "commands/command.h"
#include "evaluate/cloud_distance.h"
#include "evaluate/evaluate_run.h"
#include "evaluate/feature_points.h"
#include "evaluate/surveyed_truth.h"
#include "support/run_program.h"
#include "support/second.h"

using namespace loopline;
using loopline::test::second_ns;

namespace {

/// Straight ahead at 1 m/s for some seconds, a pose every 0.1 s.
std::vector<StampedPose> straight_path(double from_m, double to_m, double y_m, StampNs start_ns) {
    std::vector<StampedPose> path;
    const int steps = static_cast<int>(std::lround(std::abs(to_m - from_m) * 10));
    for (int i = 0; i <= steps; ++i)
        path.push_back(
            {start_ns + i * second_ns / 10, Pose3(Pose2{from_m + (to_m - from_m) * i / steps, y_m, 0})});
    return path;
}

/// The poses of a path, moved by `drift` per metre of x, every one with the sequence of its index.
Trajectory estimate_of(const std::vector<StampedPose>& truth, double drift) {
    Trajectory trajectory;
    for (const auto& pose : truth) {
        Pose3 moved = pose.T_map_base;
        moved.translation_m.y() += drift * moved.translation_m.x();
        trajectory.append(trajectory.size(), pose.stamp_ns, moved, Matrix6d::Zero());
    }
    return trajectory;
}

/// A half circle of beams at 1 degree from a vehicle at x = `at_m` + 1 m/s, onto a wall at y = 1 from x = 3
/// on.
mrpt::obs::CObservation2DRangeScan scan_of_wall(double at_m, double scan_duration_s) {
    mrpt::obs::CObservation2DRangeScan scan;
    scan.aperture = static_cast<float>(M_PI);
    scan.rightToLeft = true;
    scan.maxRange = 30;
    scan.sensorLabel = "horizontal_laser";
    scan.resizeScanAndAssign(181, 0, false);
    for (int beam = 91; beam < 180; ++beam) {
        const double angle = (beam - 90) * M_PI / 180, x_m = at_m + scan_duration_s * beam / 180;
        const double hit_x_m = x_m + 1 / std::tan(angle);
        if (hit_x_m < 3 - 1e-9) continue;
        scan.setScanRange(static_cast<std::size_t>(beam), static_cast<float>(1 / std::sin(angle)));
        scan.setScanRangeValidity(static_cast<std::size_t>(beam), true);
    }
    return scan;
}

mrpt::maps::CSimplePointsMap::Ptr cloud_of(const std::vector<Eigen::Vector3f>& points) {
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    for (const auto& p : points) cloud->insertPointFast(p.x(), p.y(), p.z());
    return cloud;
}

}  // namespace

TEST(SurveyedTruth, reads_points_walls_and_levels_and_passes_over_the_rest) {
    const test::TemporaryFolder folder;
    const auto truth = read_surveyed_truth(
        folder.write("t.csv",
                     "kind,number,x_m,y_m,x2_m,y2_m,bottom_m,top_m\n# a comment\npoint,7,1.5,-2\n"
                     "wall,1,0,0,4,0,2.8,0\nlevel,1,0\nlevel,2,2.8,,,\ntree,1,5,5\n"),
        "the truth");
    ASSERT_EQ(truth.points.size(), 1u);
    EXPECT_EQ(truth.points[0].number, 7);
    EXPECT_EQ(truth.points[0].position_m, Eigen::Vector2d(1.5, -2));
    ASSERT_EQ(truth.walls.size(), 1u);
    EXPECT_EQ(truth.walls[0].top_m, 2.8);
    EXPECT_EQ(truth.walls[0].bottom_m, 0);
    EXPECT_EQ(truth.levels_m, (std::vector<double>{0, 2.8}));
    for (const char* wrong : {"point,1,2\n", "point,1.5,2,3\n", "wall,1,0,0,4,0,2.8\n", "level,1,high\n"}) {
        try {
            read_surveyed_truth(folder.write("wrong.csv", std::string("\n") + wrong), "the truth");
            ADD_FAILURE() << wrong;
        } catch (const CommandError& error) {
            EXPECT_NE(std::string(error.what()).find("wrong.csv:2: "), std::string::npos) << error.what();
            EXPECT_EQ(error.code(), exit_input_data);
        }
    }
}

TEST(TruePath, interpolates_on_the_arc_in_any_order_of_times_and_not_across_gaps) {
    const Pose3 quarter(Pose2{2, 2, M_PI / 2});
    TruePath path({{second_ns, quarter}, {0, Pose3()}, {10 * second_ns, quarter}});
    EXPECT_NEAR(path.at(second_ns / 2)->translation_m.x(), 2 * std::sin(M_PI / 4), 1e-12);
    EXPECT_NEAR(path.at(second_ns)->translation_m.x(), 2, 1e-12);
    EXPECT_NEAR(path.at(0)->translation_m.x(), 0, 1e-12);
    EXPECT_FALSE(path.at(5 * second_ns));
    EXPECT_FALSE(path.at(-1));
    EXPECT_FALSE(path.at(11 * second_ns));
    EXPECT_NEAR(path.at(second_ns / 3)->translation_m.y(), 2 - 2 * std::cos(M_PI / 6), 1e-9);
    EXPECT_FALSE(TruePath(std::vector<StampedPose>{}).at(0));
}

TEST(FeaturePoints, the_mean_of_the_returns_within_5_cm_as_worked_out_by_hand) {
    // From (2, 0) the beams at 44 and 45 degrees meet the wall at x = 3.0355 and 3 (46 would miss it), 43
    // at 3.072.
    const auto truth = straight_path(0, 4, 0, 0);
    FeaturePointHits hits({{5, {3, 1}}}, truth, 0);
    hits.take(scan_of_wall(2, 0), 2 * second_ns, 20);
    const Trajectory odometry = estimate_of(truth, 0.5);
    const auto outcome = hits.estimates(estimate_of(truth, 0.1), &odometry);
    ASSERT_EQ(outcome.points.size(), 1u);
    const PointEstimate& point = outcome.points[0];
    EXPECT_EQ(point.number, 5);
    EXPECT_EQ(point.returns, 2u);
    EXPECT_NEAR(point.true_m.x(), 3, 1e-12);
    EXPECT_NEAR(point.estimate_m.x(), (3 + 3.035530) / 2, 1e-5);
    EXPECT_NEAR(point.estimate_m.y(), 1.2, 1e-6);
    EXPECT_NEAR(point.by_true_poses_m.x(), point.estimate_m.x(), 1e-12);
    EXPECT_NEAR(point.by_true_poses_m.y(), 1, 1e-6);
    ASSERT_TRUE(point.odometry_m);
    EXPECT_NEAR(point.odometry_m->y(), 2.0, 1e-6);
    EXPECT_NEAR(*point.odometry_error_m(), std::hypot(0.017765, 1.0), 1e-5);
}

TEST(FeaturePoints, every_return_is_carried_by_the_poses_of_its_own_time) {
    const auto truth = straight_path(0, 4, 0, 0);
    FeaturePointHits hits({{1, {3, 1}}}, truth, 0.5);
    hits.take(scan_of_wall(1.6, 0.5), 1'600'000'000, 16);
    const auto outcome = hits.estimates(estimate_of(truth, 0.1), nullptr);
    // The same by brute force: every beam from where the vehicle was at its time.
    Eigen::Vector2d sum(0, 0);
    int count = 0;
    for (int beam = 91; beam < 180; ++beam) {
        const double vehicle_m = 1.6 + 0.5 * beam / 180.0,
                     x_m = vehicle_m + 1 / std::tan((beam - 90) * M_PI / 180);
        if (x_m < 3 - 1e-9 || x_m > 3.05) continue;
        sum += Eigen::Vector2d(x_m, 1 + 0.1 * vehicle_m);
        ++count;
    }
    ASSERT_GT(count, 0);
    ASSERT_EQ(outcome.points.size(), 1u);
    EXPECT_EQ(outcome.points[0].returns, static_cast<std::size_t>(count));
    EXPECT_LT((outcome.points[0].estimate_m - sum / count).norm(), 1e-5);
    EXPECT_FALSE(outcome.points[0].odometry_m);
}

TEST(FeaturePoints, the_closest_pass_counts_and_where_the_point_was_hidden_the_next) {
    // Past the point at 4 m distance, away from it, and back past it at 1 m.
    auto truth = straight_path(0, 12, -3, 0);
    const auto back = straight_path(12, 0, 0, 13 * second_ns);
    truth.insert(truth.end(), back.begin(), back.end());
    const auto far_scan = [] {
        mrpt::obs::CObservation2DRangeScan scan = scan_of_wall(0, 0);
        scan.resizeScanAndAssign(181, 0, false);
        scan.setScanRange(180, 4);  // straight to the left
        scan.setScanRangeValidity(180, true);
        return scan;
    }();
    Trajectory estimate = estimate_of(truth, 0);
    for (std::size_t i = 0; i < estimate.size(); ++i)
        if (estimate.entries()[i].stamp_ns >= 13 * second_ns) {
            Pose3 pose = estimate.entries()[i].T_map_base;
            pose.translation_m.x() += 0.3;
            estimate.revise(i, pose, Matrix6d::Zero());
        }
    const StampNs far_ns = 3 * second_ns, near_ns = 23 * second_ns;  // at x = 3 and x = 2
    FeaturePointHits both({{1, {3, 1}}}, truth, 0);
    both.take(far_scan, far_ns, 30);
    both.take(scan_of_wall(2, 0), near_ns, 221);
    const auto near_outcome = both.estimates(estimate, nullptr);
    ASSERT_EQ(near_outcome.points.size(), 1u);
    EXPECT_EQ(near_outcome.points[0].returns, 2u);
    EXPECT_NEAR(near_outcome.points[0].estimate_m.x(), 3.317765, 1e-4);

    FeaturePointHits only_far({{1, {3, 1}}}, truth, 0);
    only_far.take(far_scan, far_ns, 30);
    const auto far_outcome = only_far.estimates(estimate, nullptr);
    ASSERT_EQ(far_outcome.points.size(), 1u);
    EXPECT_NEAR(far_outcome.points[0].estimate_m.x(), 3, 1e-6);
}

TEST(FeaturePoints, a_tilting_laser_does_not_count_and_a_point_without_returns_is_named) {
    const auto truth = straight_path(0, 4, 0, 0);
    FeaturePointHits hits({{1, {3, 1}}, {2, {1, -2}}}, truth, 0);
    auto scan = scan_of_wall(2, 0);
    hits.take(scan, 2 * second_ns, 20);
    scan.sensorPose.setYawPitchRoll(0, 0.2, 0);
    hits.take(scan, 2 * second_ns + 1000, 21);  // so it was a survey laser that just happened to be level
    const auto outcome = hits.estimates(estimate_of(truth, 0), nullptr);
    EXPECT_TRUE(outcome.points.empty());
    EXPECT_EQ(outcome.missed, (std::vector<int>{1, 2}));
    const auto evaluation = evaluate_points(outcome.points, outcome.missed);
    ASSERT_EQ(evaluation.warnings.size(), 1u);
    EXPECT_NE(evaluation.warnings[0].find("1, 2"), std::string::npos);
    EXPECT_TRUE(evaluation.metrics.empty());
}

TEST(FeaturePoints, figures_are_those_of_the_points) {
    PointEstimate a, b;
    a.estimate_m = {0.03, 0.04};
    a.odometry_m = Eigen::Vector2d(3, 4);
    b.estimate_m = {0, 0.15};
    const auto metrics = evaluate_points({a, b}, {}).metrics;
    EXPECT_NEAR(std::get<double>(metrics.at("points_mean_error_m")), 0.1, 1e-12);
    EXPECT_NEAR(std::get<double>(metrics.at("points_max_error_m")), 0.15, 1e-12);
    EXPECT_NEAR(std::get<double>(metrics.at("points_odometry_mean_error_m")), 5, 1e-12);
    EXPECT_EQ(std::get<std::int64_t>(metrics.at("points_used")), 2);
}

TEST(CloudDistance, the_nearest_wall_is_that_of_a_search_through_all) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> u(-20, 20), z(-1, 4);
    std::vector<TrueWall> walls;
    for (int i = 0; i < 150; ++i)
        walls.push_back(
            {{u(random), u(random)}, {u(random), u(random)}, std::abs(z(random)) / 4, 2 + z(random) / 8});
    WallDistance distance(walls);
    for (int i = 0; i < 5000; ++i) {
        const Eigen::Vector3d p(1.5 * u(random), 1.5 * u(random), z(random));
        double expected_m = INFINITY;
        for (const auto& wall : walls) expected_m = std::min(expected_m, distance_to_wall_m(p, wall));
        EXPECT_DOUBLE_EQ(distance(p), expected_m);
    }
    EXPECT_TRUE(std::isinf(WallDistance({})({0, 0, 0})));
    EXPECT_NEAR(WallDistance(walls)({1e7, 0, 0}), 1e7, 100);
}

TEST(CloudDistance, to_a_wall_by_hand) {
    const TrueWall wall{{0, 0}, {4, 0}, 0, 2};
    EXPECT_DOUBLE_EQ(distance_to_wall_m({2, 0.5, 1}, wall), 0.5);
    EXPECT_DOUBLE_EQ(distance_to_wall_m({7, 4, 1}, wall), 5);
    EXPECT_DOUBLE_EQ(distance_to_wall_m({2, 3, 6}, wall), 5);
    EXPECT_DOUBLE_EQ(distance_to_wall_m({0, 3, 1}, {{0, 0}, {0, 0}, 0, 2}), 3) << "a wall without length";
}

TEST(CloudDistance, floor_and_ceiling_do_not_count_and_the_frames_are_kept_apart) {
    SurveyedTruth truth;
    truth.walls = {{{0, 0}, {10, 0}, 0, 3}};
    truth.levels_m = {0, 3};
    // The map's origin lies at (1, 1) of the truth, turned by 90 degrees: its y axis looks along the truth's
    // -x.
    const Pose3 T_truth_map(Pose2{1, 1, M_PI / 2});
    const auto cloud = cloud_of({{-1, -1, 0},
                                 {-1, -1, 2.95f},
                                 {-0.9f, -1, 1},
                                 {-0.8f, -2, 1},
                                 {-0.5f, -3, 1},
                                 {-0.5f, -3, -0.5f},
                                 {NAN, 0, 1}});
    const auto distance = cloud_to_walls(*cloud, T_truth_map, truth);
    EXPECT_EQ(distance.points, 3u);
    EXPECT_NEAR(distance.median_m, 0.2, 1e-6);
    truth.levels_m.clear();
    EXPECT_EQ(cloud_to_walls(*cloud, T_truth_map, truth).points, 6u);
}

TEST(EvaluateSurveys, a_cloud_by_true_poses_lies_on_its_walls_and_one_by_drifting_ones_does_not) {
    EvaluationReference reference;
    const auto truth = straight_path(0, 4, 0, 0);
    reference.truth = StampedPath(truth);
    reference.surveyed.walls = {{{0, 1}, {10, 1}, 0, 3}};
    Results results, by_odometry;
    NamedMap map{"survey", cloud_of({{2, 1, 1}, {3, 1, 1}, {4, 1.02f, 1}})};
    map.survey = true;
    results.maps = {map, {"points", cloud_of({{50, 50, 1}})}};
    map.map = cloud_of({{2, 1.5f, 1}, {3, 2, 1}, {4, 2.5f, 1}});
    by_odometry.maps = {map};
    const Trajectory estimate = estimate_of(truth, 0), odometry = estimate_of(truth, 0.5);
    const auto metrics = evaluate_surveys(results, by_odometry, estimate, &odometry, reference).metrics;
    EXPECT_NEAR(std::get<double>(metrics.at("survey_median_m")), 0, 1e-6);
    EXPECT_NEAR(std::get<double>(metrics.at("survey_odometry_median_m")), 1, 1e-6);
    EXPECT_EQ(std::get<std::int64_t>(metrics.at("survey_wall_points")), 3);
    EXPECT_EQ(metrics.count("points_median_m"), 0u);
}
