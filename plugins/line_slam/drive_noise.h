/// The variances of a drive's noise: what there is to estimate beside slip. A wheel of a regime has two: that
/// of a random way which grows with the way that it rolled, and that of its slip from one stretch under the
/// regime to the next, as wheels and castors happen to stand.
#pragma once

#include <Eigen/Core>
#include <array>

#include "line_slam/motion_model.h"
#include "line_slam/regimes.h"

namespace loopline::line_slam {

enum class Wheel { left, right };
constexpr int wheel_count = 2;
constexpr std::array<Wheel, wheel_count> both_wheels{Wheel::left, Wheel::right};

constexpr int wheel_kinds = wheel_count * regime_count;

/// Of a left and a right wheel.
using WheelValues = std::array<double, wheel_count>;
inline double& of(WheelValues& values, Wheel wheel) {
    return values[static_cast<std::size_t>(wheel)];
}
inline double of(const WheelValues& values, Wheel wheel) {
    return values[static_cast<std::size_t>(wheel)];
}
inline double of(const WheelTravel& travel, Wheel wheel) {
    return wheel == Wheel::left ? travel.left_m : travel.right_m;
}

/// Of each wheel under each regime.
using RegimeWheelValues = std::array<WheelValues, regime_count>;
inline double& of(RegimeWheelValues& values, Regime regime, Wheel wheel) {
    return of(values[static_cast<std::size_t>(regime)], wheel);
}
inline double of(const RegimeWheelValues& values, Regime regime, Wheel wheel) {
    return of(values[static_cast<std::size_t>(regime)], wheel);
}

/// Where the logarithm of each variance stands.
constexpr int wheel_noise(Regime regime, Wheel wheel) {  ///< of the travel after 1 m, m^2
    return wheel_count * static_cast<int>(regime) + static_cast<int>(wheel);
}
constexpr int side_noise = wheel_kinds;                   ///< sideways after 1 m, m^2
constexpr int rest_noise = side_noise + 1;                ///< of each, whatever the way, m^2
constexpr int slip_scatter(Regime regime, Wheel wheel) {  ///< of the slip, from stretch to stretch
    return rest_noise + 1 + wheel_noise(regime, wheel);
}
constexpr int noise_count = rest_noise + 1 + wheel_kinds;

using NoiseVector = Eigen::Matrix<double, noise_count, 1>;
using NoiseMatrix = Eigen::Matrix<double, noise_count, noise_count>;

}  // namespace loopline::line_slam
