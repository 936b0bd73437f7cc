/// Motion by landmarks that are points.
#include "landmark_odometry/landmark_odometry.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "landmark_odometry/landmark_map.h"
#include "support/grove.h"

using namespace loopline;
using namespace loopline::landmark_odometry;
using namespace loopline::landmark_odometry::test;

namespace {

constexpr double rad = M_PI / 180;

Sighting seen(double x_m, double y_m, double sigma_m = 0.1) {
    return {{x_m, y_m}, sigma_m * sigma_m * Eigen::Matrix2d::Identity()};
}

Eigen::Vector3d off(const Pose2& from, const Pose2& to) {
    return {to.x_m - from.x_m, to.y_m - from.y_m, wrap_to_pi(to.phi_rad - from.phi_rad)};
}

/// Some way among four landmarks.
LandmarkFilter filter_on_the_way() {
    LandmarkFilter filter;
    const MotionNoise noise;
    for (const auto& [x_m, y_m] : {std::pair{8.0, 3.0}, {5.0, -6.0}, {14.0, 1.0}, {20.0, -9.0}})
        filter.add(seen(x_m, y_m));
    for (int k = 0; k < 6; ++k) filter.move({0.7, 0.02, 0.15}, noise);
    filter.update(1, filter.innovation(1, seen(-1, -8, 0.2)));
    for (int k = 0; k < 3; ++k) filter.move({0.7, 0, -0.1}, noise);
    return filter;
}

// The innovation's derivatives say how the filter's covariance becomes that of a sighting; they are told by
// two filters that differ by a little.
TEST(LandmarkFilter, jacobians_are_central_differences) {
    const Pose2 T_local_base{3, -2, 0.8};
    const Eigen::Vector2d landmark_m(9, 4);
    const auto innovation = [&](const Pose2& T, const Eigen::Vector2d& m) {
        LandmarkFilter filter;
        filter.add(seen(m.x(), m.y(), 1e-6));
        filter.move(log_se2(T), {0, 0, 0, 0});
        return filter.innovation(0, seen(0, 0));
    };
    const Innovation there = innovation(T_local_base, landmark_m);
    constexpr double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
        Eigen::Vector3d step = Eigen::Vector3d::Zero();
        step[k] = h;
        const auto moved = [&](double sign) {
            return innovation({T_local_base.x_m + sign * step[0], T_local_base.y_m + sign * step[1],
                               T_local_base.phi_rad + sign * step[2]},
                              landmark_m)
                .off_m;
        };
        EXPECT_LT(((moved(-1) - moved(1)) / (2 * h) - there.by_pose.col(k)).norm(), 1e-7);
        if (k == 2) continue;
        const auto shifted = [&](double sign) {
            return innovation(T_local_base, landmark_m + sign * step.head<2>()).off_m;
        };
        EXPECT_LT(((shifted(-1) - shifted(1)) / (2 * h) - there.by_landmark.col(k)).norm(), 1e-7);
    }
}

// The covariance after motion, against that of 20,000 drawn ones.
TEST(LandmarkFilter, covariance_of_the_way_is_that_of_drawn_ones) {
    const MotionNoise noise{0.05, 0.02, 1 * rad, 20 * rad};
    const Twist2 step{0.5, 0, 0.06};
    LandmarkFilter filter;
    for (int k = 0; k < 30; ++k) filter.move(step, noise);
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    Eigen::Matrix3d drawn = Eigen::Matrix3d::Zero();
    constexpr int draws = 20000;
    const double root = std::sqrt(step.forward_m),
                 turn = std::hypot(noise.heading_rad * root,
                                   noise.heading_per_turn_rad * std::sqrt(step.turn_rad / (2 * M_PI)));
    for (int draw = 0; draw < draws; ++draw) {
        Pose2 T;
        for (int k = 0; k < 30; ++k)
            T = T * exp_se2({step.forward_m + noise.along_m * root * normal(random),
                             noise.across_m * root * normal(random), step.turn_rad + turn * normal(random)});
        const Eigen::Vector3d d = off(filter.T_local_base(), T);
        drawn += d * d.transpose() / draws;
    }
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(filter.pose_covariance()(i, i) / drawn(i, i), 1, 0.06) << i;
    EXPECT_NEAR(filter.pose_covariance()(1, 2) / drawn(1, 2), 1, 0.06);
}

// Without turns all of it is linear: the filter is least squares over everything at once.
TEST(LandmarkFilter, is_least_squares_where_nothing_turns) {
    const MotionNoise noise{0.1, 0.05, 0, 0};
    LandmarkFilter filter;
    // Unknowns: two places of the vehicle, two landmarks.
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(12, 8);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(12), weight(12);
    auto row = [&, next = 0](int plus, int minus, const Eigen::Vector2d& value, double sx,
                             double sy) mutable {
        for (int axis = 0; axis < 2; ++axis) {
            A(next, plus + axis) = 1;
            if (minus >= 0) A(next, minus + axis) = -1;
            b[next] = value[axis];
            weight[next] = 1 / (axis == 0 ? sx * sx : sy * sy);
            ++next;
        }
    };
    filter.add(seen(5, 2));
    row(4, -1, {5, 2}, 0.1, 0.1);
    filter.move({1, 0, 0}, noise);
    row(0, -1, {1, 0}, 0.1, 0.05);
    filter.add(seen(6, -3, 0.2));
    row(6, 0, {6, -3}, 0.2, 0.2);
    filter.update(0, filter.innovation(0, seen(4.1, 1.95)));
    row(4, 0, {4.1, 1.95}, 0.1, 0.1);
    filter.move({1, 0, 0}, noise);
    row(2, 0, {1, 0}, 0.1, 0.05);
    filter.update(1, filter.innovation(1, seen(4.9, -2.8)));
    row(6, 2, {4.9, -2.8}, 0.1, 0.1);

    const Eigen::MatrixXd information = A.transpose() * weight.asDiagonal() * A;
    const Eigen::VectorXd x = information.ldlt().solve(A.transpose() * weight.asDiagonal() * b);
    const Eigen::MatrixXd covariance = information.inverse();
    EXPECT_LT((filter.T_local_base().translation() - x.segment<2>(2)).norm(), 1e-9);
    EXPECT_LT((filter.p_local_m(0) - x.segment<2>(4)).norm(), 1e-9);
    EXPECT_LT((filter.p_local_m(1) - x.segment<2>(6)).norm(), 1e-9);
    EXPECT_LT((filter.pose_covariance().topLeftCorner<2, 2>() - covariance.block<2, 2>(2, 2)).norm(), 1e-9);
    EXPECT_LT((filter.landmark_covariance_m2(1) - covariance.block<2, 2>(6, 6)).norm(), 1e-9);
}

// What can be seen from the vehicle does not know in which frame it is written down.
TEST(LandmarkFilter, another_frame_changes_nothing_that_is_seen) {
    LandmarkFilter filter = filter_on_the_way(), anew = filter;
    anew.begin_anew();
    EXPECT_EQ(anew.pose_covariance().norm(), 0);
    EXPECT_EQ(off(anew.T_local_base(), Pose2{}).norm(), 0);
    const auto expect_same = [&] {
        for (std::size_t m = 0; m < filter.landmarks(); ++m) {
            const Innovation a = filter.innovation(m, seen(4, 4)), b = anew.innovation(m, seen(4, 4));
            EXPECT_LT((a.off_m - b.off_m).norm(), 1e-12);
            EXPECT_LT((a.covariance_m2 - b.covariance_m2).norm(), 1e-12 * a.covariance_m2.norm());
        }
    };
    expect_same();
    for (LandmarkFilter* one : {&filter, &anew}) {
        one->move({0.5, 0, 0.1}, MotionNoise{});
        Innovation small = one->innovation(2, seen(0, 0));
        small.off_m = {0.01, -0.02};
        one->update(2, small);
    }
    // The update moves the pose, so that what was linearised before differs by its square.
    for (std::size_t m = 0; m < filter.landmarks(); ++m)
        EXPECT_LT((filter.innovation(m, seen(4, 4)).off_m - anew.innovation(m, seen(4, 4)).off_m).norm(),
                  1e-3);
}

TEST(LandmarkFilter, a_landmark_that_is_forgotten_leaves_the_others_as_they_are) {
    const LandmarkFilter whole = filter_on_the_way();
    LandmarkFilter filter = whole;
    filter.remove(1);
    ASSERT_EQ(filter.landmarks(), 3U);
    for (std::size_t m = 0; m < 3; ++m) {
        const std::size_t before = m < 1 ? m : m + 1;
        EXPECT_EQ((filter.p_local_m(m) - whole.p_local_m(before)).norm(), 0);
        EXPECT_EQ((filter.innovation(m, seen(1, 2)).covariance_m2 -
                   whole.innovation(before, seen(1, 2)).covariance_m2)
                      .norm(),
                  0);
    }
}

TEST(LandmarkOdometry, recovers_a_known_way_where_nothing_errs) {
    GroveSettings exact;
    exact.errs = false;
    exact.sigma_range_m = 1e-3;
    exact.sigma_bearing_rad = 0.01 * rad;
    exact.missed = exact.false_sightings = 0;
    exact.motion = {0, 0, 0, 0};
    exact.scale = 1.01;  // but the wheels, all the way
    exact.turn_scale = 0.98;
    Grove grove(exact, 1);
    LandmarkOdometry odometry({});
    odometry.take({}, grove.look());
    // Three sightings make a landmark: until then the wheels lead.
    Pose2 T_odom_map;
    double worst_m = 0;
    while (grove.way_m() < 400) {
        const Twist2 told = grove.drive();
        odometry.take(told, grove.look());
        const Pose3 T = odometry.pose().T_map_base;
        const Pose2 T_odom_base{T.translation_m.x(), T.translation_m.y(), T.yaw_rad()};
        if (grove.way_m() < 2) T_odom_map = T_odom_base * grove.T_map_base().inverse();
        worst_m = std::max(worst_m, off(T_odom_map * grove.T_map_base(), T_odom_base).head<2>().norm());
    }
    EXPECT_LT(worst_m, 0.01) << "of 400 m: what is not linear in wheels that are 1 % too long";
}

// A walker beside the vehicle is seen in every scan, and is no tree.
TEST(LandmarkOdometry, who_walks_along_does_not_lead) {
    GroveSettings settings;
    settings.false_sightings = 0;
    Grove grove(settings, 5), alone(settings, 5);
    LandmarkOdometry with({}), without({});
    double apart_m = 0;
    with.take({}, grove.look());
    without.take({}, alone.look());
    while (grove.way_m() < 200) {
        const Twist2 told = grove.drive();
        auto sightings = grove.look();
        sightings.push_back(seen(6, 3));
        sightings.push_back(seen(9, -2));
        with.take(told, sightings);
        alone.drive();
        without.take(told, alone.look());
        apart_m = std::max(
            apart_m, (with.pose().T_map_base.translation_m - without.pose().T_map_base.translation_m).norm());
    }
    EXPECT_LT(apart_m, 0.3);
}

TEST(LandmarkOdometry, memory_is_that_of_the_landmarks_about) {
    GroveSettings settings;
    settings.half_side_m = 200;
    Grove grove(settings, 2);
    LandmarkOdometry odometry({});
    odometry.take({}, grove.look());
    std::size_t first = 0, later = 0;
    while (grove.way_m() < 1600) {
        const Twist2 told = grove.drive();
        odometry.take(told, grove.look());
        (grove.way_m() < 400 ? first : later) =
            std::max(grove.way_m() < 400 ? first : later, odometry.filter().landmarks());
    }
    EXPECT_LE(later, first + first / 4);
}

TEST(LandmarkMap, has_each_tree_once_and_nothing_that_was_seen_by_chance) {
    std::mt19937_64 random(6);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> side(-50, 50);
    // On a raster of 5 m, each shifted by up to 1 m, seen 30 times by sensors that err by 0.1 to 0.5 m.
    std::vector<Eigen::Vector2d> trees_m;
    for (int x = -5; x <= 5; ++x)
        for (int y = -5; y <= 5; ++y)
            trees_m.emplace_back(5 * x + side(random) / 50, 5 * y + side(random) / 50);
    LandmarkMap map(1.5);
    for (int look = 0; look < 30; ++look) {
        for (const Eigen::Vector2d& tree_m : trees_m) {
            const double sigma_m = 0.1 + 0.4 * (look % 5) / 4;
            map.add(tree_m + sigma_m * Eigen::Vector2d(normal(random), normal(random)),
                    sigma_m * sigma_m * Eigen::Matrix2d::Identity());
        }
        for (int chance = 0; chance < 3; ++chance)
            map.add({100 + side(random), side(random)}, 0.01 * Eigen::Matrix2d::Identity());
    }
    const auto mapped = map.landmarks(10);
    ASSERT_EQ(mapped.size(), trees_m.size());
    for (std::size_t k = 0; k < mapped.size(); ++k) {
        EXPECT_LT((mapped[k].p_map_m - trees_m[k]).norm(), 0.15) << k;
        EXPECT_NEAR(mapped[k].sightings, 30, 2);
    }
}

}  // namespace
