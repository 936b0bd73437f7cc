/// Wheel odometry with what logs hold beside good readings.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "fusion/wheel_readings.h"

using namespace loopline;
using namespace loopline::fusion;

namespace {

using Verdict = WheelReadings::Verdict;
constexpr StampNs step_ns = 50'000'000;  // 20 Hz, 8 m/s

/// Where the vehicle is after 100 readings, if from the 50th on the odometry's pose is another one.
WheelReadings after_a_jump(const Pose2& T_other_told) {
    WheelReadings readings;
    Pose2 T;
    for (int k = 0; k < 100; ++k) {
        const Verdict verdict = readings.take(step_ns * (k + 1), k < 50 ? T : T_other_told * T);
        const bool jumps = k == 50 && T_other_told.translation().norm() > 0;
        EXPECT_EQ(verdict, jumps ? Verdict::implausible : Verdict::good) << k;
        T = T * Pose2{0.4, 0, 0.01};
    }
    return readings;
}

TEST(WheelReadings, a_pose_that_is_set_anew_moves_nothing) {
    const Pose2 expected = after_a_jump({}).T_odom_base();
    for (const Pose2& jump : {Pose2{500, 0, 0}, Pose2{-20, 3, 2}}) {
        const WheelReadings readings = after_a_jump(jump);
        EXPECT_NEAR(readings.T_odom_base().x_m, expected.x_m, 0.01);
        EXPECT_NEAR(readings.T_odom_base().y_m, expected.y_m, 0.01);
        EXPECT_NEAR(readings.T_odom_base().phi_rad, expected.phi_rad, 1e-3);
        EXPECT_NEAR(readings.motion().forward_m, 0.4, 1e-3);
        EXPECT_EQ(readings.count(Verdict::implausible), 1);
        EXPECT_EQ(readings.taken(), 100);
    }
}

TEST(WheelReadings, what_can_not_be_used_is_counted_and_changes_nothing) {
    WheelReadings readings;
    readings.take(1 * step_ns, {0, 0, 0});
    readings.take(2 * step_ns, {0.4, 0, 0});
    EXPECT_EQ(readings.take(2 * step_ns, {0.8, 0, 0}), Verdict::backward);
    EXPECT_EQ(readings.take(3 * step_ns, {0.8, std::numeric_limits<double>::quiet_NaN(), 0}),
              Verdict::not_finite);
    EXPECT_EQ(readings.T_odom_base().x_m, 0.4);
    EXPECT_EQ(readings.take(3 * step_ns, {0.8, 0, 0}), Verdict::good);
    EXPECT_NEAR(readings.motion().forward_m, 0.4, 1e-12);
    EXPECT_EQ(readings.count(Verdict::backward), 1);
    EXPECT_EQ(readings.count(Verdict::not_finite), 1);
}

TEST(WheelReadings, that_come_in_bunches_are_not_too_fast) {
    WheelReadings readings;
    for (int k = 0; k < 20; ++k)
        EXPECT_EQ(readings.take(step_ns * (k / 2) + 1'000'000 * (k % 2), {1.0 * k, 0, 0}), Verdict::good);
}

}  // namespace
