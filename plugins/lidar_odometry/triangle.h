/// The plane of three planar points: two of one ring, one of another.
#pragma once

#include <array>

#include "lidar_odometry/features.h"

namespace loopline::lidar_odometry {

/// The points outlive it.
class Triangle {
 public:
    Triangle(const Feature& corner, const Feature& same_ring, const Feature& other_ring);

    /// Whether it is one, and no rings lie across it: those of its points, and that of the point that is
    /// drawn onto it.
    bool is_plane(const Eigen::Vector3d& along_before, double max_sine) const;
    /// Whether the foot of a point is in it or close by.
    bool covers(const Eigen::Vector3d& p_m) const;
    /// Whether a fourth point lies on the plane, but for noise.
    bool agrees_with(const Feature& fourth, double sigma_bend_per_m) const;

    const Eigen::Vector3d& normal() const { return normal_; }
    const Eigen::Vector3d& corner_m() const { return corner_m_; }
    /// Of the plane along its normal, at the foot of a point.
    double variance_m2(const Eigen::Vector3d& p_m, double sigma_bend_per_m) const;
    /// What an error of each point by its standard deviation along the normal turns the normal by.
    std::array<Eigen::Vector3d, 3> turned_by() const;

 private:
    std::array<double, 3> parts(const Eigen::Vector3d& p_m) const;

    std::array<const Feature*, 3> points_;
    Eigen::Vector3d corner_m_, side_a_m_, side_b_m_, normal_;
    bool wide_ = false;
    std::array<Eigen::Vector3d, 3> slopes_;  ///< of the barycentric coordinates
};

}  // namespace loopline::lidar_odometry
