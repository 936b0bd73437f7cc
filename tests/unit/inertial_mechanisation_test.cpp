/// Strapdown mechanisation: against a drive known in closed form, order of the error, and its inverse.
#include <gtest/gtest.h>

#include "inertial/imu_observation.h"
#include "inertial/mechanisation.h"
#include "support/inertial_drive.h"

using namespace loopline;
using namespace loopline::inertial;

namespace {

const ImuNoise silent{{0, 0}, {0, 0}};
const ImuNoise coarse_mems{{1e-3, 1e-5}, {1e-2, 1e-4}};

struct Parting {
    double position_m, velocity_mps, attitude_rad;
};
Parting parting(const NavigationState& a, const NavigationState& b) {
    const ErrorVector e = error_between(a, b);
    return {e.segment<3>(position_error).norm(), e.segment<3>(velocity_error).norm(),
            e.segment<3>(attitude_error).norm()};
}

/// The end of a silent drive by the mechanisation, against the truth.
Parting end_error(double duration_s, double rate_hz) {
    std::mt19937_64 random(1);
    const auto run = test::simulate_imu({}, duration_s, rate_hz, silent, {}, random);
    const Mechanisation mechanisation;
    NavigationState state = run.truth.front();
    for (std::size_t i = 1; i < run.samples.size(); ++i)
        state = mechanisation.forward(state, run.samples[i - 1], run.samples[i]);
    return parting(state, run.truth.back());
}

/// Forward and back again over the same readings.
Parting undone(const test::InertialRun& run) {
    const Mechanisation mechanisation;
    const NavigationState start = run.truth.front();
    NavigationState state = start;
    for (std::size_t i = 1; i < run.samples.size(); ++i)
        state = mechanisation.forward(state, run.samples[i - 1], run.samples[i]);
    for (std::size_t i = run.samples.size() - 1; i > 0; --i)
        state = mechanisation.reverse(state, run.samples[i - 1], run.samples[i]);
    EXPECT_EQ(state.stamp_ns, start.stamp_ns);
    EXPECT_EQ(state.gyro_bias_radps, start.gyro_bias_radps);
    EXPECT_EQ(state.accelerometer_bias_mps2, start.accelerometer_bias_mps2);
    return parting(state, start);
}

}  // namespace

TEST(InertialMechanisation, follows_a_known_drive_with_an_error_of_second_order) {
    const Parting coarse = end_error(30, 50), fine = end_error(30, 100);
    EXPECT_LT(fine.attitude_rad, 1e-5);
    EXPECT_LT(fine.velocity_mps, 1e-4);
    EXPECT_LT(fine.position_m, 2e-3);
    EXPECT_NEAR(coarse.attitude_rad / fine.attitude_rad, 4, 0.1);
    EXPECT_NEAR(coarse.velocity_mps / fine.velocity_mps, 4, 0.4);
    EXPECT_NEAR(coarse.position_m / fine.position_m, 4, 0.4);
}

TEST(InertialMechanisation, at_rest_and_tilted_nothing_moves) {
    NavigationState state;
    state.q_map_base = exp_so3({0.2, -0.3, 1});
    ImuSample a, b;
    a.specific_force_base_mps2 = state.q_map_base.conjugate() * Eigen::Vector3d(0, 0, 9.80665);
    b = a;
    b.stamp_ns = 1'000'000'000;
    const auto next = Mechanisation().forward(state, a, b);
    EXPECT_LT(parting(next, state).position_m, 1e-14);
    EXPECT_LT(parting(next, state).velocity_mps, 1e-14);
}

TEST(InertialMechanisation, reverse_undoes_ten_minutes_of_a_silent_drive) {
    std::mt19937_64 random(2);
    const auto apart = undone(test::simulate_imu({}, 600, 100, silent, {}, random));
    EXPECT_LT(apart.position_m, 1e-10);
    EXPECT_LT(apart.velocity_mps, 1e-12);
    EXPECT_LT(apart.attitude_rad, 1e-12);
}

TEST(InertialMechanisation, reverse_undoes_ten_minutes_of_noisy_readings_with_wrong_biases) {
    std::mt19937_64 random(3);
    NavigationState start;
    start.gyro_bias_radps = {0.01, -0.02, 0.03};
    start.accelerometer_bias_mps2 = {0.1, -0.05, 0.2};
    auto run = test::simulate_imu({}, 600, 100, coarse_mems, start, random);
    run.truth.front().gyro_bias_radps += Eigen::Vector3d(1e-3, -5e-4, 2e-3);  // it drifts off by some 10 km
    const auto apart = undone(run);
    EXPECT_LT(apart.position_m, 2e-9);
    EXPECT_LT(apart.velocity_mps, 1e-11);
    EXPECT_LT(apart.attitude_rad, 1e-12);
}

TEST(InertialMechanisation, the_quaternion_stays_of_unit_length) {
    std::mt19937_64 random(4);
    const auto run = test::simulate_imu({}, 100, 100, coarse_mems, {}, random);
    NavigationState state = run.truth.front();
    for (std::size_t i = 1; i < run.samples.size(); ++i)
        state = Mechanisation().forward(state, run.samples[i - 1], run.samples[i]);
    EXPECT_NEAR(state.q_map_base.norm(), 1, 1e-15);
}

TEST(InertialSample, is_turned_to_the_axes_of_the_vehicle) {
    using namespace mrpt::obs;
    CObservationIMU observation;
    observation.sensorPose = {0.1, 0.2, 0.3, 0, 0, M_PI / 2};  // its y axis points up
    observation.set(IMU_WX, 1);
    observation.set(IMU_WY, 2);
    observation.set(IMU_WZ, 3);
    observation.set(IMU_X_ACC, 0.5);
    observation.set(IMU_Y_ACC, 9.8);
    EXPECT_FALSE(reading_from_mrpt(observation, 5));
    observation.set(IMU_Z_ACC, 0.25);
    const auto reading = reading_from_mrpt(observation, 5);
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading->omega_imu_radps, Eigen::Vector3d(1, 2, 3));
    const ImuSample sample = reading->along_base();
    EXPECT_EQ(sample.stamp_ns, 5);
    EXPECT_LT((sample.omega_base_radps - Eigen::Vector3d(1, -3, 2)).norm(), 1e-12);
    EXPECT_LT((sample.specific_force_base_mps2 - Eigen::Vector3d(0.5, -0.25, 9.8)).norm(), 1e-12);
    EXPECT_LT((p_base_imu_m(observation) - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12);
}
