/// A smooth drive on a level floor, known in closed form, and the readings of a MEMS IMU on it.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "inertial/error_state.h"
#include "inertial/rotation_vector.h"

namespace loopline::test {

/// Heading and speed are sums of sines, the velocity is along the heading. The position is their integral.
struct SmoothDrive {
    double gravity_mps2 = 9.80665;
    double turning_radps = 0.3;  ///< how quickly left and right follow each other

    double heading_rad(double t_s) const { return 0.9 * std::sin(turning_radps * t_s) + 0.1 * t_s; }
    double heading_rate_radps(double t_s) const {
        return 0.9 * turning_radps * std::cos(turning_radps * t_s) + 0.1;
    }
    double speed_mps(double t_s) const { return 1 + 0.4 * std::sin(0.5 * t_s); }
    double acceleration_mps2(double t_s) const { return 0.2 * std::cos(0.5 * t_s); }
    Eigen::Vector3d v_map_mps(double t_s) const {
        return speed_mps(t_s) * Eigen::Vector3d(std::cos(heading_rad(t_s)), std::sin(heading_rad(t_s)), 0);
    }
    /// Simpson's rule, over so short a time that it is exact to rounding.
    Eigen::Vector3d way_m(double from_s, double to_s) const {
        const double h = to_s - from_s;
        return h / 6 * (v_map_mps(from_s) + 4 * v_map_mps(from_s + h / 2) + v_map_mps(to_s));
    }
    inertial::ImuSample reading(double t_s) const {
        inertial::ImuSample sample;
        sample.stamp_ns = std::llround(t_s * 1e9);
        sample.omega_base_radps = {0, 0, heading_rate_radps(t_s)};
        sample.specific_force_base_mps2 = {acceleration_mps2(t_s), speed_mps(t_s) * heading_rate_radps(t_s),
                                           gravity_mps2};
        return sample;
    }
};

/// Readings and the true states at their times, biases included.
struct InertialRun {
    std::vector<inertial::ImuSample> samples;
    std::vector<inertial::NavigationState> truth;
};

/// `noise` is white in each reading, and walks in the biases, which begin at those of `start`. The pose and
/// velocity of `start` are the drive's own.
inline InertialRun simulate_imu(const SmoothDrive& drive, double duration_s, double rate_hz,
                                const inertial::ImuNoise& noise, inertial::NavigationState start,
                                std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const auto white = [&](double sigma) {
        const double x = normal(random), y = normal(random), z = normal(random);
        return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
    };
    InertialRun run;
    const double dt_s = 1 / rate_hz;
    for (int i = 0; i <= std::lround(duration_s * rate_hz); ++i) {
        const double t_s = i * dt_s;
        start.stamp_ns = std::llround(t_s * 1e9);
        start.q_map_base = inertial::exp_so3({0, 0, drive.heading_rad(t_s)});
        start.v_map_mps = drive.v_map_mps(t_s);
        if (i > 0) start.p_map_m += drive.way_m(t_s - dt_s, t_s);
        run.truth.push_back(start);

        inertial::ImuSample sample = drive.reading(t_s);
        sample.omega_base_radps +=
            start.gyro_bias_radps + white(noise.gyro.density_radps_sqrt_hz / std::sqrt(dt_s));
        sample.specific_force_base_mps2 +=
            start.accelerometer_bias_mps2 + white(noise.accelerometer.density_mps2_sqrt_hz / std::sqrt(dt_s));
        run.samples.push_back(sample);
        start.gyro_bias_radps += white(noise.gyro.bias_walk_radps_sqrt_s * std::sqrt(dt_s));
        start.accelerometer_bias_mps2 += white(noise.accelerometer.bias_walk_mps2_sqrt_s * std::sqrt(dt_s));
    }
    return run;
}

}  // namespace loopline::test
