/// How a vehicle with a spinning lidar moves, from sweep to sweep and within one.
#include <gtest/gtest.h>

#include "support/lidar_yard.h"

using namespace loopline;
using namespace loopline::lidar_mapping;
using namespace loopline::lidar_yard;

namespace {

TEST(MotionState, prediction_has_the_covariance_of_samples) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    MotionState state = driving();
    Vector12d sigma;
    sigma << 0.1, 0.2, 0.1, 0.01, 0.02, 0.03, 0.5, 0.3, 0.2, 0.05, 0.02, 0.04;
    state.covariance = sigma.cwiseAbs2().asDiagonal();
    const MotionNoise noise{2, 0.5, 1, 0.3};
    const double duration_s = 0.3;
    const MotionState predicted = predict(state, duration_s, noise);
    Matrix12d sum = Matrix12d::Zero();
    constexpr int samples = 20000;
    for (int k = 0; k < samples; ++k) {
        Vector12d off;
        for (int i = 0; i < 12; ++i) off[i] = sigma[i] * normal(random);
        MotionState sample = moved_by(state, off);
        sample.T_map_base = sample.T_map_base * exp_se3(sample.velocity * duration_s);
        Vector12d pushed;
        for (int i = 0; i < 3; ++i) {
            const double a = noise.sigma_acceleration_mps2 * normal(random),
                         w = noise.sigma_turn_radps2 * normal(random);
            pushed[i] = a * duration_s * duration_s / 2;
            pushed[3 + i] = w * duration_s * duration_s / 2;
            pushed[6 + i] = a * duration_s;
            pushed[9 + i] = w * duration_s;
        }
        // Velocities are compared along the axes of the map before and after, which the turn moves little.
        const Vector12d d = difference(sample, predicted) + pushed;
        sum += d * d.transpose() / samples;
    }
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(std::sqrt(sum(i, i) / predicted.covariance(i, i)), 1, 0.05) << i;
    EXPECT_NEAR(sum(1, 5) / predicted.covariance(1, 5), 1, 0.15);
    EXPECT_NEAR(sum(0, 6) / predicted.covariance(0, 6), 1, 0.15);
}

TEST(MotionState, difference_undoes_a_step) {
    const MotionState state = driving();
    Vector12d step;
    step << 0.1, -0.2, 0.3, 0.4, 0.1, -0.2, 1, 2, -1, 0.3, 0.1, 0.2;
    EXPECT_LT((difference(moved_by(state, step), state) - step).norm(), 1e-12);
}

TEST(MotionState, difference_within_a_sweep_undoes_a_step) {
    MotionState state = driving();
    state.jerk = {{1, 2, 3}, {4, 5, 6}};
    SweepVector step;
    for (Eigen::Index i = 0; i < sweep_errors; ++i) step[i] = 0.1 * std::sin(1.0 + static_cast<double>(i));
    EXPECT_LT((sweep_difference(sweep_moved_by(state, step), state) - step).norm(), 1e-12);
}

/// Springs let a vehicle roll and pitch, whichever way it stands on the map.
TEST(MotionState, expects_more_of_roll_and_pitch_than_of_the_heading) {
    MotionState state = driving();
    state.T_map_base.rotation = inertial::exp_so3({0, 0, 1.2});
    state.covariance = Matrix12d::Identity();
    const SweepMatrix covariance = sweep_covariance(predict(state, 0.1, {}));
    for (const Eigen::Index at : {12, 18}) {
        const Eigen::Matrix3d turn = covariance.block<3, 3>(at + 3, at + 3);
        EXPECT_NEAR(turn(0, 0) / turn(1, 1), 1, 1e-3);
        EXPECT_GT(turn(0, 0), 5 * turn(2, 2));
        EXPECT_LT(std::abs(turn(0, 1)), 1e-3 * turn(0, 0));
    }
}

TEST(SweepMotion, is_a_cubic_with_the_rates_it_is_said_to_have) {
    MotionState state = driving();
    state.velocity_before = {{6, 0.3, 0}, {0, -0.2, 0.1}};
    state.duration_s = 0.08;
    state.acceleration_off = {{1, 2, 3}, {0.1, 0.2, 0.3}};
    state.jerk = {{30, -20, 10}, {3, 2, -1}};
    const SweepMotion motion(state);
    const double h = 0.01;
    const Twist3 before = motion.after(-h), there = motion.after(0), after = motion.after(h);
    EXPECT_EQ(there.shift_m.norm() + there.turn_rad.norm(), 0);
    const Twist3 acceleration = (before + after) * (1 / (h * h));
    const Twist3 mean = (state.velocity - state.velocity_before) * (1 / state.duration_s);
    EXPECT_LT((acceleration.shift_m - mean.shift_m - state.acceleration_off.shift_m).norm(), 1e-9);
    EXPECT_LT((acceleration.turn_rad - mean.turn_rad - state.acceleration_off.turn_rad).norm(), 1e-9);
    const Twist3 odd = (after - before) * 0.5 - state.velocity * h;
    EXPECT_LT((odd.shift_m * (6 / (h * h * h)) - state.jerk.shift_m).norm(), 1e-7);
    EXPECT_LT((odd.turn_rad * (6 / (h * h * h)) - state.jerk.turn_rad).norm(), 1e-7);
}

TEST(SweepMotion, moves_with_the_velocity_as_differences_say) {
    MotionState state = driving();
    state.velocity_before = {{6, 0.3, 0}, {0, -0.2, 0.1}};
    state.duration_s = 0.08;
    for (const double s : {-0.05, -0.01, 0.03, 0.05}) {
        MotionState faster = state, slower = state;
        faster.velocity.shift_m.x() += 1e-3;
        slower.velocity.shift_m.x() -= 1e-3;
        const double difference_s =
            (SweepMotion(faster).after(s).shift_m.x() - SweepMotion(slower).after(s).shift_m.x()) / 2e-3;
        EXPECT_NEAR(SweepMotion(state).by_velocity_s(s), difference_s, 1e-9);
    }
    // Half of the way back it had the mean of both velocities.
    const double h = 1e-4, then_s = -state.duration_s / 2;
    const Twist3 rate =
        (SweepMotion(state).after(then_s + h) - SweepMotion(state).after(then_s - h)) * (0.5 / h);
    EXPECT_NEAR(rate.shift_m.x(), (state.velocity.shift_m.x() + state.velocity_before.shift_m.x()) / 2, 1e-6);
    EXPECT_NEAR(rate.turn_rad.z(), (state.velocity.turn_rad.z() + state.velocity_before.turn_rad.z()) / 2,
                1e-6);
}

}  // namespace
