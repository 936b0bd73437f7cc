/// Motions that another odometry gives the map: poses as observations, the motion between two times, and the
/// prediction by it.
#include <gtest/gtest.h>

#include <random>

#include "api/pose_observation.h"
#include "inertial/rotation_vector.h"
#include "lidar_mapping/published_odometry.h"

using namespace loopline;
using namespace loopline::lidar_mapping;

namespace {

/// (shift, turn), or an error of it.
using Shift6d = Eigen::Matrix<double, 6, 1>;

Shift6d shift_and_turn(const Pose3& found, const Pose3& truth) {
    const Twist3 off = log_se3(found * truth.inverse());
    Shift6d v;
    v << off.shift_m, off.turn_rad;
    return v;
}

/// Errors of poses, put through both forms.
TEST(PoseObservation, keeps_pose_and_covariance) {
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    const Pose3 T({1, -2, 3}, inertial::exp_so3({0.3, -0.5, 2}));
    Matrix6d A;
    for (int i = 0; i < 36; ++i) A(i) = 1e-3 * normal(random);
    const Matrix6d covariance = A * A.transpose();
    const auto observation = pose_observation("a", stamp_to_mrpt(1000000000), T, covariance);
    const PoseWithCovariance back = pose_of(*observation);
    EXPECT_LT((back.T_map_base.translation_m - T.translation_m).norm(), 1e-12);
    EXPECT_LT(back.T_map_base.rotation.angularDistance(T.rotation), 1e-9);
    EXPECT_LT((back.covariance - covariance).norm(), 1e-9 * covariance.norm());
    Matrix6d sampled = Matrix6d::Zero();
    constexpr int samples = 20000;
    for (int k = 0; k < samples; ++k) {
        Shift6d unit;
        for (int i = 0; i < 6; ++i) unit[i] = normal(random);
        const Shift6d error = A * unit;
        const auto moved = pose_observation(
            "a", stamp_to_mrpt(1000000000),
            {T.translation_m + error.head<3>(), inertial::exp_so3(error.tail<3>()) * T.rotation}, covariance);
        Shift6d off;
        const auto &m = moved->pose.mean, &o = observation->pose.mean;
        off << m.x() - o.x(), m.y() - o.y(), m.z() - o.z(), m.yaw() - o.yaw(), m.pitch() - o.pitch(),
            m.roll() - o.roll();
        sampled += off * off.transpose() / samples;
    }
    EXPECT_LT((sampled - Matrix6d(observation->pose.cov.asEigen())).norm(), 0.05 * sampled.norm());
}

/// Poses of an odometry at 0, 0.1, 0.2 s; the covariance of the way is what it added.
TEST(PublishedOdometry, tells_the_motion_between_two_times_and_its_covariance) {
    PublishedOdometrySettings settings;
    settings.label = "odo";
    settings.sigma_m = 1e-6;
    settings.sigma_rad = 1e-6;
    PublishedOdometry odometry(settings);
    const Twist3 velocity{{5, 0, 0.1}, {0, 0.1, 0.4}};
    const Pose3 first({100, 50, 2}, inertial::exp_so3({0.2, 0.1, 1}));
    Matrix6d step = Matrix6d::Zero();
    step.diagonal() << 4e-4, 1e-4, 1e-4, 1e-6, 1e-6, 2e-6;
    Matrix6d covariance = 1e-2 * Matrix6d::Identity();
    Pose3 T = first;
    for (int k = 0; k < 3; ++k) {
        const auto stamp = stamp_to_mrpt(1000000000LL + 100000000LL * k);
        EXPECT_FALSE(odometry.take(*pose_observation("another", stamp, T, covariance)));
        EXPECT_TRUE(odometry.take(*pose_observation("odo", stamp, T, covariance)));
        const Pose3 next = T * exp_se3(velocity * 0.1);
        Matrix6d F = Matrix6d::Identity(), R = Matrix6d::Zero();
        F.topRightCorner<3, 3>() = -inertial::cross_matrix(next.translation_m - T.translation_m);
        R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = T.rotation.toRotationMatrix();
        covariance = F * covariance * F.transpose() + R * step * R.transpose();
        T = next;
    }
    EXPECT_TRUE(odometry.reaches(1200000000));
    EXPECT_FALSE(odometry.reaches(1200000001));
    // Half a step beyond the last pose.
    const auto given = odometry.motion(1150000000, 1250000000);
    ASSERT_TRUE(given);
    EXPECT_FALSE(given->planar);
    EXPECT_LT(shift_and_turn(given->T_last_now, exp_se3(velocity * 0.1)).norm(), 1e-9);
    EXPECT_LT((given->velocity.shift_m - velocity.shift_m).norm(), 1e-9);
    EXPECT_LT((given->covariance - step).norm(), 0.01 * step.norm());
}

/// A pose with an error and a motion with one, put together.
TEST(GivenMotion, prediction_has_the_covariance_of_samples) {
    std::mt19937_64 random(12);
    std::normal_distribution<double> normal;
    MotionState state = first_state({});
    state.T_map_base = {{10, 5, 1}, inertial::exp_so3({0.05, -0.1, 1.2})};
    Shift6d sigma, sigma_given;
    sigma << 0.1, 0.2, 0.1, 0.01, 0.02, 0.03;
    sigma_given << 0.05, 0.02, 0.03, 0.01, 0.004, 0.02;
    state.covariance.topLeftCorner<6, 6>() = sigma.cwiseAbs2().asDiagonal();
    GivenMotion given;
    given.T_last_now = exp_se3({{2, 0.1, 0}, {0, 0.05, 0.2}});
    given.covariance = sigma_given.cwiseAbs2().asDiagonal();
    given.velocity = {{20, 0, 0}, {0, 0, 2}};
    const MotionState predicted = predict(state, given, 0.1, {});
    EXPECT_LT(shift_and_turn(predicted.T_map_base, state.T_map_base * given.T_last_now).norm(), 1e-12);
    EXPECT_EQ(predicted.velocity.shift_m, given.velocity.shift_m);
    Matrix6d sum = Matrix6d::Zero();
    constexpr int samples = 20000;
    for (int k = 0; k < samples; ++k) {
        Shift6d e, g;
        for (int i = 0; i < 6; ++i) {
            e[i] = sigma[i] * normal(random);
            g[i] = sigma_given[i] * normal(random);
        }
        const auto put = [](const Pose3& T, const Shift6d& x) {
            return Pose3(T.translation_m + x.head<3>(), inertial::exp_so3(x.tail<3>()) * T.rotation);
        };
        const Pose3 T = put(state.T_map_base, e) * put(given.T_last_now, g);
        Shift6d off;
        off << T.translation_m - predicted.T_map_base.translation_m,
            inertial::log_so3(T.rotation * predicted.T_map_base.rotation.conjugate());
        sum += off * off.transpose() / samples;
    }
    const Matrix6d covariance = predicted.covariance.topLeftCorner<6, 6>();
    EXPECT_LT((sum - covariance).norm(), 0.05 * covariance.norm());
}

/// What wheels do not tell goes on as it was.
TEST(GivenMotion, of_wheels_changes_shift_and_heading_only) {
    MotionState state = first_state({});
    state.velocity = {{8, 0, 0.5}, {0.1, -0.2, 0}};
    GivenMotion given;
    given.planar = true;
    given.T_last_now = exp_se3({{0.6, 0.02, 0}, {0, 0, 0.05}});
    given.velocity = {{6, 0.2, 0}, {0, 0, 0.5}};
    given.covariance = 1e-4 * Matrix6d::Identity();
    const MotionState predicted = predict(state, given, 0.1, {3, 1.5, 1, 0.3});
    const Twist3 moved = log_se3(predicted.T_map_base);
    EXPECT_LT((moved.shift_m - Eigen::Vector3d(0.6, 0.02, 0.05)).norm(), 1e-9);
    EXPECT_LT((moved.turn_rad - Eigen::Vector3d(0.01, -0.02, 0.05)).norm(), 1e-9);
    EXPECT_EQ(predicted.velocity.shift_m, Eigen::Vector3d(6, 0.2, 0.5));
}

/// Height, roll and pitch, and their velocities, are known together as if there were no wheels: a sweep that
/// tells the lean then tells how it changes, too.
TEST(GivenMotion, of_wheels_leaves_what_they_do_not_tell_as_certain_as_without_them) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    const MotionNoise noise{3, 0.3, 1, 0.3};
    MotionState state = first_state(noise);
    state.velocity = {{8, 0, 0.5}, {0.1, -0.2, 0}};
    Matrix12d root;
    for (int i = 0; i < 144; ++i) root(i) = 0.01 * normal(random);
    state.covariance = root * root.transpose();
    GivenMotion given;
    given.planar = true;
    given.T_last_now = exp_se3(state.velocity * 0.1);
    given.velocity = state.velocity;
    given.covariance = 1e-4 * Matrix6d::Identity();
    given.velocity_over_s = 0;
    const MotionState with = predict(state, given, 0.1, noise), without = predict(state, 0.1, noise);
    for (const int a : {2, 3, 4, 8, 9, 10})
        for (const int b : {2, 3, 4, 8, 9, 10})
            EXPECT_NEAR(with.covariance(a, b), without.covariance(a, b), 1e-12) << a << " " << b;
}

/// Along a tunnel an odometry with a wrong scale is off by that part of the whole way; where sweeps hold the
/// way, by that part of a step.
TEST(GivenMotion, error_of_its_scale_adds_up_where_no_sweep_holds_the_way) {
    constexpr int steps = 100;
    const Pose3 start({5, 6, 1}, inertial::exp_so3({0.02, -0.01, 0.8}));
    GivenMotion given;
    given.T_last_now = {{1.2, 0, 0}, Eigen::Quaterniond::Identity()};
    given.sigma_scale = 0.01;
    MotionState state;
    state.T_map_base = start;
    for (int k = 0; k < steps; ++k) state = predict(state, given, 0.1, {});
    const Eigen::Matrix3d covariance = state.covariance.topLeftCorner<3, 3>();
    const Eigen::Vector3d along = start.rotation * Eigen::Vector3d::UnitX();
    EXPECT_NEAR(std::sqrt(along.dot(covariance * along)), 0.01 * 1.2 * steps, 1e-9);
    EXPECT_NEAR(covariance.trace(), along.dot(covariance * along), 1e-9);
    state.way_on_trust_m = 0;
    state.covariance.setZero();
    state = predict(state, given, 0.1, {});
    EXPECT_NEAR(std::sqrt(state.covariance.topLeftCorner<3, 3>().trace()), 0.01 * 1.2, 1e-9);
}

}  // namespace
