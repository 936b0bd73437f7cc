#include "fusion/wheel_motion.h"

namespace loopline::fusion {

Twist2 corrected(const Twist2& told, const Eigen::Vector3d& errors) {
    const double longer = 1 + errors[way_scale];
    return {longer * told.forward_m, longer * told.left_m,
            (1 + errors[turn_scale]) * told.turn_rad + errors[bend] * told.forward_m};
}

/// exp(f, l, w) = (a f - b l, b f + a l), a = sin w / w, b = (1 - cos w) / w.
Eigen::Matrix<double, 6, 3> by_wheel_errors(const Twist2& told, const Eigen::Vector3d& errors) {
    const Twist2 twist = corrected(told, errors);
    const double w = twist.turn_rad, half_sine = std::sin(w / 2);
    const bool straight = std::abs(w) < 1e-4;
    const double a = straight ? 1 - w * w / 6 : std::sin(w) / w,
                 b = straight ? w / 2 : 2 * half_sine * half_sine / w;
    const double a_by_w = straight ? -w / 3 : (std::cos(w) - a) / w,
                 b_by_w = straight ? 0.5 - w * w / 8 : (std::sin(w) - b) / w;
    const Eigen::Vector2d by_way(a * told.forward_m - b * told.left_m, b * told.forward_m + a * told.left_m),
        by_turn(a_by_w * twist.forward_m - b_by_w * twist.left_m,
                b_by_w * twist.forward_m + a_by_w * twist.left_m);
    Eigen::Matrix<double, 6, 3> J = Eigen::Matrix<double, 6, 3>::Zero();
    J.col(way_scale).head<2>() = by_way;
    J.col(turn_scale).head<2>() = told.turn_rad * by_turn;
    J.col(bend).head<2>() = told.forward_m * by_turn;
    J(5, turn_scale) = told.turn_rad;
    J(5, bend) = told.forward_m;
    return J;
}

Matrix6d noise_of(const Twist2& told, const WheelNoise& noise) {
    const double way_m = std::hypot(told.forward_m, told.left_m),
                 turns = std::abs(told.turn_rad) / (2 * M_PI);
    const auto square = [](double x) { return x * x; };
    Eigen::Matrix<double, 6, 1> variance;
    variance << square(noise.along_m), square(noise.across_m), square(noise.up_m), square(noise.tilt_rad),
        square(noise.tilt_rad), square(noise.turn_rad);
    variance *= way_m;
    variance[5] += square(noise.turn_per_turn_rad) * turns;
    variance.array() += 1e-12;  // a wheel that stands may have rolled within its last tick
    return variance.asDiagonal();
}

}  // namespace loopline::fusion
