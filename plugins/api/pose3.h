/// Spatial poses: unit quaternion and translation, so that a rotation stays orthonormal however often it is composed.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "api/pose2.h"

namespace loopline {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A spatial rigid transform: `T_a_b` maps coordinates in frame b to frame a. x forward, y left, z up.
struct Pose3 {
    Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();

    Pose3() = default;
    Pose3(const Eigen::Vector3d& t_m, const Eigen::Quaterniond& q) : translation_m(t_m), rotation(q) {}
    /// In the plane z = 0, turned about z.
    explicit Pose3(const Pose2& planar)
        : translation_m(planar.x_m, planar.y_m, 0),
          rotation(std::cos(planar.phi_rad / 2), 0, 0, std::sin(planar.phi_rad / 2)) {}

    Pose3 operator*(const Pose3& other) const {
        return {translation_m + rotation * other.translation_m, (rotation * other.rotation).normalized()};
    }
    Eigen::Vector3d operator*(const Eigen::Vector3d& point_m) const { return rotation * point_m + translation_m; }
    Pose3 inverse() const {
        const Eigen::Quaterniond q = rotation.conjugate();
        return {-(q * translation_m), q};
    }

    /// Heading: angle of the x axis' projection on the horizontal plane, counter-clockwise from x.
    double yaw_rad() const {
        const auto& q = rotation;
        return std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z()));
    }
    /// Position and heading; height, roll and pitch are dropped.
    Pose2 planar() const { return {translation_m.x(), translation_m.y(), yaw_rad()}; }
};

}  // namespace loopline
