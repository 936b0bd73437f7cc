#include "api/pose3_motion.h"

#include <cmath>

namespace loopline {
namespace {

/// The coefficients of V = I + b [w]x + c [w]x^2 in exp(v, w) = (V v, Exp(w)), at the angle |w|.
struct ScrewCoefficients {
    double b, c;
};

ScrewCoefficients screw_coefficients(double angle_rad) {
    const double square = angle_rad * angle_rad;
    // (1 - cos a) / a^2 without cancellation; (a - sin a) / a^3 as a series where it would cancel.
    const double half = angle_rad / 2, sinc_half = half == 0 ? 1 : std::sin(half) / half;
    const double c = angle_rad < 0.1 ? (1 - square / 20 * (1 - square / 42 * (1 - square / 72))) / 6
                                     : (angle_rad - std::sin(angle_rad)) / (square * angle_rad);
    return {sinc_half * sinc_half / 2, c};
}

}  // namespace

Pose3 exp_se3(const Twist3& twist) {
    const Eigen::Vector3d &v = twist.shift_m, &w = twist.turn_rad;
    const double angle_rad = w.norm(), half = angle_rad / 2;
    const double sinc_half = half == 0 ? 1 : std::sin(half) / half;
    const auto [b, c] = screw_coefficients(angle_rad);
    const Eigen::Vector3d w_v = w.cross(v);
    Pose3 T_start_end;
    T_start_end.translation_m = v + b * w_v + c * w.cross(w_v);
    T_start_end.rotation.w() = std::cos(half);
    T_start_end.rotation.vec() = 0.5 * sinc_half * w;
    return T_start_end;
}

Twist3 log_se3(const Pose3& T_start_end) {
    Eigen::Quaterniond q = T_start_end.rotation;
    if (q.w() < 0) q.coeffs() = -q.coeffs();  // the same rotation, the shorter way
    const double sine_half = q.vec().norm(), half = std::atan2(sine_half, q.w());
    Twist3 twist;
    twist.turn_rad = (sine_half == 0 ? 2 : 2 * half / sine_half) * q.vec();
    // V^-1 = I - [w]x / 2 + d [w]x^2 with d = (1 - (a / 2) cot(a / 2)) / a^2, by its series for small angles.
    const double angle_rad = 2 * half, square = angle_rad * angle_rad;
    const double d = angle_rad < 0.1 ? (1 + square / 60 * (1 + square / 42 * (1 + square / 40))) / 12
                                     : (1 - half * q.w() / sine_half) / square;
    const Eigen::Vector3d& p = T_start_end.translation_m;
    const Eigen::Vector3d w_p = twist.turn_rad.cross(p);
    twist.shift_m = p - 0.5 * w_p + d * twist.turn_rad.cross(w_p);
    return twist;
}

Pose3 interpolate_se3(const Pose3& T_map_a, const Pose3& T_map_b, double u) {
    return T_map_a * exp_se3(log_se3(T_map_a.inverse() * T_map_b) * u);
}

ScrewSegment::ScrewSegment(StampNs a_ns, const Pose3& T_map_a, StampNs b_ns, const Pose3& T_map_b)
    : a_ns_(a_ns), T_map_a_(T_map_a) {
    if (a_ns == b_ns) return;
    velocity_ = log_se3(T_map_a.inverse() * T_map_b) * (1 / seconds_between(a_ns, b_ns));
}

}  // namespace loopline
