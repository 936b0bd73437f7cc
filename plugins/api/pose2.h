/// Planar poses for the algorithms: no MRPT type, no hidden cache.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace loopline {

/// `angle_rad` wrapped to (-pi, pi].
inline double wrap_to_pi(double angle_rad) {
    if (angle_rad > -M_PI && angle_rad <= M_PI) return angle_rad;
    const double wrapped = std::remainder(angle_rad, 2 * M_PI);
    return wrapped <= -M_PI ? wrapped + 2 * M_PI : wrapped;
}

/// A planar rigid transform: `T_a_b` maps coordinates in frame b to frame a. x forward, y left, phi
/// counter-clockwise.
struct Pose2 {
    double x_m = 0;
    double y_m = 0;
    double phi_rad = 0;

    Eigen::Vector2d translation() const { return {x_m, y_m}; }

    /// T_a_c = T_a_b * T_b_c.
    Pose2 operator*(const Pose2& other) const {
        const double c = std::cos(phi_rad), s = std::sin(phi_rad);
        return {x_m + c * other.x_m - s * other.y_m, y_m + s * other.x_m + c * other.y_m,
                wrap_to_pi(phi_rad + other.phi_rad)};
    }

    /// p_a = T_a_b * p_b.
    Eigen::Vector2d operator*(const Eigen::Vector2d& point_m) const {
        const double c = std::cos(phi_rad), s = std::sin(phi_rad);
        return {x_m + c * point_m.x() - s * point_m.y(), y_m + s * point_m.x() + c * point_m.y()};
    }

    Pose2 inverse() const {
        const double c = std::cos(phi_rad), s = std::sin(phi_rad);
        return {-c * x_m - s * y_m, s * x_m - c * y_m, wrap_to_pi(-phi_rad)};
    }
};

/// A pose prepared for many products with it in front: its sine and cosine are taken once.
class PreparedPose2 {
 public:
    PreparedPose2() = default;
    explicit PreparedPose2(const Pose2& T_a_b)
        : T_a_b_(T_a_b), cos_(std::cos(T_a_b.phi_rad)), sin_(std::sin(T_a_b.phi_rad)) {}

    const Pose2& pose() const { return T_a_b_; }
    /// T_a_c = T_a_b * T_b_c, as Pose2 has it.
    Pose2 operator*(const Pose2& T_b_c) const {
        return {T_a_b_.x_m + cos_ * T_b_c.x_m - sin_ * T_b_c.y_m,
                T_a_b_.y_m + sin_ * T_b_c.x_m + cos_ * T_b_c.y_m, wrap_to_pi(T_a_b_.phi_rad + T_b_c.phi_rad)};
    }

 private:
    Pose2 T_a_b_;
    double cos_ = 1, sin_ = 0;
};

}  // namespace loopline
