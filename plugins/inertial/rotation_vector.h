/// Rotations by their vector (axis times angle): exponential map and left Jacobian of SO(3). Sola, Deray,
/// Atchuthan 2018, "A micro Lie theory for state estimation in robotics", eq. (132) and (145).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace loopline::inertial {

/// [a]x: cross_matrix(a) * b = a x b.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
    Eigen::Matrix3d A;
    A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return A;
}

/// sin(x) / x.
inline double sinc(double x) {
    return std::abs(x) < 1e-4 ? 1 - x * x / 6 : std::sin(x) / x;
}

/// Exp: the unit quaternion of a rotation by `turn_rad`. Exp(-turn) is its exact conjugate.
inline Eigen::Quaterniond exp_so3(const Eigen::Vector3d& turn_rad) {
    const double half_rad = turn_rad.norm() / 2;
    const Eigen::Vector3d v = sinc(half_rad) / 2 * turn_rad;
    return {std::cos(half_rad), v.x(), v.y(), v.z()};
}

/// Log: the shortest rotation vector of a unit quaternion.
inline Eigen::Vector3d log_so3(const Eigen::Quaterniond& q) {
    const double sign = q.w() < 0 ? -1 : 1, sine = q.vec().norm();
    const double half_rad = std::atan2(sine, sign * q.w());
    return sign * 2 / sinc(half_rad) * q.vec();
}

/// Jl in Exp(turn + d) = Exp(Jl(turn) d) Exp(turn), to first order in d.
inline Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& turn_rad) {
    const double angle = turn_rad.norm();
    const double b = 0.5 * sinc(angle / 2) * sinc(angle / 2);  // (1 - cos) / angle^2
    const double c = angle < 1e-2 ? 1.0 / 6 - angle * angle / 120 : (1 - sinc(angle)) / (angle * angle);
    const Eigen::Matrix3d W = cross_matrix(turn_rad);
    return Eigen::Matrix3d::Identity() + b * W + c * W * W;
}

/// The least rotation that turns the unit vector `up` to z; where it points straight down, half a turn about x.
inline Eigen::Quaterniond upright(const Eigen::Vector3d& up) {
    const Eigen::Quaterniond q(1 + up.z(), up.y(), -up.x(), 0);  // (1 + up . z, up x z), twice the half angle
    return q.norm() > 1e-6 ? q.normalized() : Eigen::Quaterniond(0, 1, 0, 0);
}

}  // namespace loopline::inertial
