/// Planar motion at constant twist: exponential and logarithm of SE(2), and interpolation along the arc
/// between two poses. Sola, Deray, Atchuthan 2018, "A micro Lie theory for state estimation in robotics", eq.
/// (156)-(158).
#pragma once

#include <cmath>

#include "api/pose2.h"

namespace loopline {

/// A constant planar velocity times its duration, in the moving base frame: metres forward, metres left,
/// radians counter-clockwise. Divided by a time it is a velocity.
struct Twist2 {
    double forward_m = 0;
    double left_m = 0;
    double turn_rad = 0;

    Twist2 operator*(double factor) const { return {factor * forward_m, factor * left_m, factor * turn_rad}; }
};

/// Where `twist` ends: T_start_end. A turn of any size is followed along its arc.
inline Pose2 exp_se2(const Twist2& twist) {
    const double w = twist.turn_rad, half_sine = std::sin(w / 2);
    const double a = w == 0 ? 1 : std::sin(w) / w;
    const double b = w == 0 ? 0 : 2 * half_sine * half_sine / w;  // (1 - cos w) / w, without cancellation
    return {a * twist.forward_m - b * twist.left_m, b * twist.forward_m + a * twist.left_m, wrap_to_pi(w)};
}

/// The shortest constant twist that leads to `T_start_end`: its turn lies in (-pi, pi].
inline Twist2 log_se2(const Pose2& T_start_end) {
    const double w = T_start_end.phi_rad, half_sine = std::sin(w / 2);
    const double a = w == 0 ? 1 : std::sin(w) / w;
    const double b = w == 0 ? 0 : 2 * half_sine * half_sine / w;
    const double determinant = a * a + b * b;  // = 2 (1 - cos w) / w^2: at least 4 / pi^2
    return {(a * T_start_end.x_m + b * T_start_end.y_m) / determinant,
            (-b * T_start_end.x_m + a * T_start_end.y_m) / determinant, w};
}

/// The pose at the part `u` of the constant-twist way from `T_map_a` (u = 0) to `T_map_b` (u = 1); other u
/// extrapolate.
inline Pose2 interpolate_se2(const Pose2& T_map_a, const Pose2& T_map_b, double u) {
    return T_map_a * exp_se2(log_se2(T_map_a.inverse() * T_map_b) * u);
}

}  // namespace loopline
