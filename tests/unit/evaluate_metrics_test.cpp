/// The metrics against cases whose answer is known in closed form, and against brute force.
#include <gtest/gtest.h>

#include <random>

#include "evaluate/absolute_error.h"
#include "evaluate/consistency.h"
#include "evaluate/evaluate_run.h"
#include "evaluate/kitti_segments.h"
#include "evaluate/relations.h"
#include "evaluate/relative_error.h"
#include "support/second.h"

using namespace loopline;
using loopline::test::second_ns;

namespace {

StampedPose planar(double stamp_s, double x_m, double y_m, double phi_rad) {
    return {static_cast<StampNs>(std::llround(stamp_s * 1e9)), Pose3(Pose2{x_m, y_m, phi_rad})};
}

Pose3 random_pose(std::mt19937_64& random) {
    std::uniform_real_distribution<double> length(-20, 20), component(-1, 1);
    return {{length(random), length(random), length(random)},
            Eigen::Quaterniond(component(random), component(random), component(random), component(random))
                .normalized()};
}

std::vector<PosePair> straight(std::size_t poses, double step_m) {
    std::vector<PosePair> pairs(poses);
    for (std::size_t i = 0; i < poses; ++i) {
        pairs[i].stamp_ns = static_cast<StampNs>(i) * second_ns;
        pairs[i].T_ref_base_reference.translation_m.x() = step_m * static_cast<double>(i);
        pairs[i].T_map_base_estimate = pairs[i].T_ref_base_reference;
    }
    return pairs;
}

}  // namespace

TEST(Statistics, of_known_values) {
    const Statistics s = statistics_of({4, 1, 3, 2});
    EXPECT_EQ(s.count, 4u);
    EXPECT_DOUBLE_EQ(s.mean, 2.5);
    EXPECT_DOUBLE_EQ(s.median, 2.5);
    EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
    EXPECT_DOUBLE_EQ(s.std_deviation, std::sqrt(1.25));
    EXPECT_DOUBLE_EQ(s.max, 4);
    EXPECT_EQ(statistics_of({}).count, 0u);
}

TEST(Association, agrees_with_brute_force_on_stamps_in_any_order) {
    std::mt19937_64 random(5);
    std::uniform_int_distribution<StampNs> stamp(0, 100 * second_ns);
    std::vector<StampedPose> estimate(300), reference(200);
    for (auto& p : estimate) p.stamp_ns = stamp(random);
    for (std::size_t i = 0; i < reference.size(); ++i)
        reference[i] = {stamp(random), Pose3(Pose2{static_cast<double>(i), 0, 0})};
    const auto pairs = associate_by_stamp(estimate, reference, 0.2);
    std::size_t matched = 0;
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        std::size_t nearest = 0;
        for (std::size_t j = 1; j < reference.size(); ++j)
            if (std::abs(reference[j].stamp_ns - estimate[i].stamp_ns) <
                std::abs(reference[nearest].stamp_ns - estimate[i].stamp_ns))
                nearest = j;
        if (std::abs(reference[nearest].stamp_ns - estimate[i].stamp_ns) > second_ns / 5) continue;
        ASSERT_LT(matched, pairs.size());
        EXPECT_EQ(pairs[matched].estimate_index, i);
        EXPECT_EQ(pairs[matched].T_ref_base_reference.translation_m.x(), static_cast<double>(nearest));
        ++matched;
    }
    EXPECT_EQ(matched, pairs.size());
    EXPECT_GT(matched, 100u);
    EXPECT_TRUE(associate_by_stamp(estimate, {}, 1).empty());
    EXPECT_EQ(associate_by_stamp({planar(1, 0, 0, 0)}, {planar(1.1, 0, 0, 0)}, 0.1).size(), 1u)
        << "the limit counts";
}

TEST(Association, tracked_positions_are_interpolated_for_the_point_that_was_tracked) {
    // A vehicle turns on a circle of 2 m; a mark 0.5 m ahead and 0.2 m left of it is tracked at other times.
    std::vector<StampedPose> estimate, tracked;
    const Eigen::Vector2d mark_m(0.5, 0.2);
    const auto on_circle = [](double stamp_s) {
        return planar(stamp_s, 2 * std::cos(0.1 * stamp_s), 2 * std::sin(0.1 * stamp_s),
                      0.1 * stamp_s + M_PI / 2);
    };
    for (int i = 0; i < 100; ++i) estimate.push_back(on_circle(0.37 * i));
    for (int i = 99; i >= 0; --i) {
        StampedPose& p = tracked.emplace_back(on_circle(0.4 * i));
        p.T_map_base.translation_m.head<2>() = p.T_map_base.planar() * mark_m;
        p.T_map_base.rotation.setIdentity();
    }
    const auto pairs = associate_positions(way_of_point(estimate, mark_m), tracked, 0.2);
    EXPECT_EQ(pairs.size(), 100u);
    // A chord of 0.4 s leaves the circle by r (0.04 rad)^2 / 8 = 0.5 mm.
    EXPECT_LT(absolute_error(pairs, Alignment::none).distance_m.max, 0.6e-3);
    EXPECT_GT(absolute_error(associate_positions(estimate, tracked, 0.2), Alignment::planar).distance_m.rmse,
              1e-3);

    const std::vector<StampedPose> far = {planar(0, 0, 0, 0), planar(10, 10, 0, 0)};
    EXPECT_EQ(associate_positions({planar(0.1, 0, 0, 0)}, far, 0.2)[0].T_ref_base_reference.translation_m.x(),
              0)
        << "nobody knows what was between";
    EXPECT_TRUE(associate_positions({planar(5, 0, 0, 0)}, far, 0.2).empty());
    EXPECT_EQ(
        associate_positions({planar(10.1, 0, 0, 0)}, far, 0.2)[0].T_ref_base_reference.translation_m.x(), 10);
}

TEST(AbsoluteError, recovers_any_rigid_motion_in_the_plane_and_in_space) {
    std::mt19937_64 random(11);
    for (int run = 0; run < 50; ++run) {
        const Pose3 T_ref_map = random_pose(random);
        const Pose3 T_ref_map_planar(T_ref_map.planar());
        std::vector<PosePair> spatial(20), flat(20);
        for (auto& pair : spatial) {
            pair.T_map_base_estimate = random_pose(random);
            pair.T_ref_base_reference = T_ref_map * pair.T_map_base_estimate;
        }
        for (auto& pair : flat) {
            pair.T_map_base_estimate = Pose3(random_pose(random).planar());
            pair.T_ref_base_reference = T_ref_map_planar * pair.T_map_base_estimate;
        }
        const AbsoluteError in_space = absolute_error(spatial, Alignment::automatic);
        EXPECT_EQ(in_space.alignment, Alignment::spatial);
        EXPECT_LT(in_space.distance_m.max, 1e-12 * 1e3);
        EXPECT_LT((in_space.T_ref_map.translation_m - T_ref_map.translation_m).norm(), 1e-10);
        const AbsoluteError in_plane = absolute_error(flat, Alignment::automatic);
        EXPECT_EQ(in_plane.alignment, Alignment::planar);
        EXPECT_LT(in_plane.distance_m.max, 1e-12 * 1e3);
        EXPECT_GT(absolute_error(flat, Alignment::none).distance_m.max, 0.1);
    }
}

TEST(AbsoluteError, is_the_least_sum_of_squares) {
    // A square of side 2 whose reference has one corner 1 m too far out: the optimum by a fine search around
    // it.
    std::vector<PosePair> pairs(4);
    const double corners[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    for (std::size_t i = 0; i < 4; ++i) {
        pairs[i].T_map_base_estimate = Pose3(Pose2{corners[i][0], corners[i][1], 0});
        pairs[i].T_ref_base_reference = Pose3(Pose2{corners[i][0] + (i == 0), corners[i][1], 0});
    }
    const double best = absolute_error(pairs, Alignment::planar).distance_m.rmse;
    EXPECT_NEAR(absolute_error(pairs, Alignment::spatial).distance_m.rmse, best, 1e-9)
        << "planar data, spatial method";
    double searched = 1e9;
    for (double x = -0.5; x <= 0.5; x += 0.01)
        for (double y = -0.2; y <= 0.2; y += 0.01)
            for (double phi = -0.3; phi <= 0.3; phi += 0.005) {
                double sum = 0;
                for (const auto& pair : pairs)
                    sum += (Pose2{x, y, phi} * pair.T_map_base_estimate.translation_m.head<2>().eval() -
                            pair.T_ref_base_reference.translation_m.head<2>())
                               .squaredNorm();
                searched = std::min(searched, std::sqrt(sum / 4));
            }
    EXPECT_LE(best, searched + 1e-12);
    EXPECT_NEAR(best, searched, 1e-3);
}

TEST(RelativeError, of_a_scaled_straight_path_and_a_constant_turn) {
    auto pairs = straight(101, 0.5);
    for (auto& pair : pairs) pair.T_map_base_estimate.translation_m *= 1.02;
    const RelativeError one = relative_error(pairs, {});
    EXPECT_EQ(one.translation_m.count, 100u);
    EXPECT_NEAR(one.translation_m.rmse, 0.01, 1e-12);
    EXPECT_NEAR(one.translation_m.max, 0.01, 1e-12);
    EXPECT_NEAR(one.rotation_deg.max, 0, 1e-12);
    const RelativeError ten_metres = relative_error(pairs, {RelativeStep::Unit::metres, 10});
    EXPECT_EQ(ten_metres.translation_m.count, 81u);
    EXPECT_NEAR(ten_metres.translation_m.mean, 0.2, 1e-12);
    const RelativeError seven_seconds = relative_error(pairs, {RelativeStep::Unit::seconds, 7});
    EXPECT_EQ(seven_seconds.translation_m.count, 94u);
    EXPECT_NEAR(seven_seconds.translation_m.mean, 0.07, 1e-12);

    auto turning = straight(11, 1);
    for (std::size_t i = 0; i < turning.size(); ++i)
        turning[i].T_map_base_estimate =
            turning[i].T_ref_base_reference * Pose3(Pose2{0, 0, 0.01 * static_cast<double>(i)});
    EXPECT_NEAR(relative_error(turning, {RelativeStep::Unit::poses, 5}).rotation_deg.mean, 0.05 * 180 / M_PI,
                1e-9);
}

TEST(RelativeError, is_blind_to_the_frames) {
    std::mt19937_64 random(2);
    auto pairs = straight(30, 1);
    for (auto& pair : pairs) pair.T_map_base_estimate = pair.T_map_base_estimate * random_pose(random);
    const RelativeError before = relative_error(pairs, {});
    const Pose3 T_other_map = random_pose(random);
    for (auto& pair : pairs) pair.T_map_base_estimate = T_other_map * pair.T_map_base_estimate;
    const RelativeError after = relative_error(pairs, {});
    EXPECT_NEAR(after.translation_m.rmse, before.translation_m.rmse, 1e-9);
    EXPECT_NEAR(after.rotation_deg.rmse, before.rotation_deg.rmse, 1e-9);
}

TEST(KittiSegments, begin_and_end_where_the_development_kit_has_them) {
    // One metre a pose, 251 poses, 2 % too long: beginnings 0, 10, ...; 100 m are exceeded at the 101st pose
    // after.
    auto pairs = straight(251, 1);
    for (auto& pair : pairs) pair.T_map_base_estimate.translation_m *= 1.02;
    const KittiError error = kitti_error(pairs);
    // 100 m: first + 101 <= 250, first = 0 .. 140: 15 segments; 200 m: first = 0 .. 40: 5 segments.
    ASSERT_EQ(error.segments.size(), 20u);
    EXPECT_EQ(error.segments[0].last, 101u);
    EXPECT_EQ(error.segments[1].last, 201u);
    EXPECT_EQ(error.segments.back().first, 140u);
    EXPECT_NEAR(error.translation_percent, (15 * 2.02 + 5 * 2 * 2.01 / 2) / 20, 1e-9);
    EXPECT_NEAR(error.rotation_deg_per_m, 0, 1e-12);
    EXPECT_TRUE(kitti_error(straight(101, 1)).segments.empty()) << "100 m must be exceeded";
}

TEST(KittiSegments, a_drifting_heading_gives_its_own_rate) {
    auto pairs = straight(400, 1);
    const double rate_rad_per_m = 1e-4;
    Pose3 estimate;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        pairs[i].T_map_base_estimate = estimate;
        estimate = estimate * Pose3(Pose2{1, 0, rate_rad_per_m});
    }
    const KittiError error = kitti_error(pairs);
    double expected = 0;  // (length + 1) steps over a nominal length
    for (const auto& segment : error.segments)
        expected += rate_rad_per_m * (segment.length_m + 1) / segment.length_m;
    EXPECT_NEAR(error.rotation_deg_per_m, expected / static_cast<double>(error.segments.size()) * 180 / M_PI,
                1e-12);
}

TEST(Relations, interpolation_gaps_and_the_two_microseconds) {
    const std::vector<StampedPose> path = {planar(10, 1, 0, 3.0), planar(0, 0, 0, 0), planar(12, 3, 0, -3.0),
                                           planar(30, 4, 0, 0)};
    const auto error_of = [&](double first_s, double second_s, Pose2 motion) {
        return relations_error({{static_cast<StampNs>(std::llround(first_s * 1e9)),
                                 static_cast<StampNs>(std::llround(second_s * 1e9)), motion}},
                               path, {});
    };
    // Half-way between 10 and 12 s the heading passes pi, not 0.
    const RelationsError halfway = error_of(0, 11, {2, 0, M_PI});
    ASSERT_EQ(halfway.translation_m.count, 1u);
    EXPECT_NEAR(halfway.translation_m.mean, 0, 1e-12);
    EXPECT_NEAR(halfway.rotation_deg.mean, 0, 1e-9);
    EXPECT_EQ(error_of(0, 5, {}).translation_m.count, 0u) << "5 s from both neighbours";
    EXPECT_EQ(error_of(0, 28, {}).translation_m.count, 1u) << "2 s from one";
    EXPECT_EQ(error_of(0, 30.1, {}).translation_m.count, 0u) << "after the end";
    EXPECT_EQ(error_of(0, 30.0000019, {4, 0, 0}).translation_m.count, 1u);
    EXPECT_EQ(error_of(0, 30.0000021, {4, 0, 0}).translation_m.count, 0u);
    EXPECT_NEAR(error_of(0, 10, {1, 0, 3.0 - 0.1}).rotation_deg.mean, 0.1 * 180 / M_PI, 1e-9);
}

TEST(Relations, odometry_carries_the_nearer_pose) {
    // The path is known at 0 and 1 s; the odometry, in another frame, waits and then turns and drives at
    // once.
    const std::vector<StampedPose> path = {planar(0, 0, 0, 0), planar(1, 1, 0, 0)};
    const std::vector<StampedPose> odometry = {planar(0, 5, 5, M_PI / 2), planar(0.4, 5, 5, M_PI / 2),
                                               planar(0.45, 5, 5.3, M_PI / 2), planar(1, 5, 6, M_PI / 2)};
    const std::vector<Relation> relation = {{0, 450'000'000, {0.3, 0, 0}}};
    EXPECT_NEAR(relations_error(relation, path, {}).translation_m.mean, 0.15, 1e-12);
    EXPECT_NEAR(relations_error(relation, path, odometry).translation_m.mean, 0, 1e-12);
}

TEST(Consistency, nees_of_errors_drawn_from_the_covariance_lies_in_the_band) {
    std::mt19937_64 random(9);
    std::normal_distribution<double> normal;
    Eigen::Matrix3d root;
    root << 0.3, 0, 0, -0.1, 0.2, 0, 0.02, 0.01, 0.05;
    const int runs = 2000;
    double sum = 0;
    for (int i = 0; i < runs; ++i) {
        const Eigen::Vector3d e = root * Eigen::Vector3d(normal(random), normal(random), normal(random));
        const auto nees = pose_nees({1 + e.x(), 2 + e.y(), wrap_to_pi(M_PI + e.z())}, {1, 2, M_PI},
                                    root * root.transpose());
        ASSERT_TRUE(nees);
        sum += *nees;
    }
    const Band band = nees_band_95(3, runs);
    EXPECT_GT(sum / runs, band.low);
    EXPECT_LT(sum / runs, band.high);
    EXPECT_FALSE(pose_nees({}, {}, Eigen::Matrix3d::Zero()));
    // Tables of chi-square with 150 degrees of freedom: 117.98 and 185.80.
    EXPECT_NEAR(nees_band_95(3, 50).low * 50, 117.98, 0.05);
    EXPECT_NEAR(nees_band_95(3, 50).high * 50, 185.80, 0.05);
}
