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
