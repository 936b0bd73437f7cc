#include "lidar_odometry/triangle.h"

#include <Eigen/Geometry>
#include <cmath>

namespace loopline::lidar_odometry {
namespace {

constexpr double least_side_m = 0.05;
constexpr double least_sine = 0.1;   ///< of the angle between two sides
constexpr double around = 1;         ///< of its size, that it is used beyond its borders
constexpr double agrees_sigmas = 2;  ///< of a fourth point

}  // namespace

Triangle::Triangle(const Feature& corner, const Feature& same_ring, const Feature& other_ring)
    : points_{&corner, &same_ring, &other_ring},
      corner_m_(corner.p_base_m.cast<double>()),
      side_a_m_(same_ring.p_base_m.cast<double>() - corner_m_),
      side_b_m_(other_ring.p_base_m.cast<double>() - corner_m_) {
    const Eigen::Vector3d twice_area = side_a_m_.cross(side_b_m_);
    const double size = twice_area.norm();
    wide_ = side_a_m_.norm() > least_side_m && size > least_sine * side_a_m_.norm() * side_b_m_.norm();
    if (!wide_) return;
    normal_ = twice_area / size;
    slopes_[1] = side_b_m_.cross(normal_) / size;
    slopes_[2] = normal_.cross(side_a_m_) / size;
    slopes_[0] = -(slopes_[1] + slopes_[2]);
}

bool Triangle::is_plane(const Eigen::Vector3d& along_before, double max_sine) const {
    if (!wide_ || std::abs(normal_.dot(along_before)) > max_sine) return false;
    for (const Feature* point : points_)
        if (std::abs(normal_.dot(point->along_base.cast<double>())) > max_sine) return false;
    return true;
}

/// Barycentric coordinates of the foot of a point.
std::array<double, 3> Triangle::parts(const Eigen::Vector3d& p_m) const {
    const double a = slopes_[1].dot(p_m - corner_m_), b = slopes_[2].dot(p_m - corner_m_);
    return {1 - a - b, a, b};
}

bool Triangle::covers(const Eigen::Vector3d& p_m) const {
    for (const double part : parts(p_m))
        if (part < -around || part > 1 + around) return false;
    return true;
}

double Triangle::variance_m2(const Eigen::Vector3d& p_m, double sigma_bend_per_m) const {
    const auto part = parts(p_m);
    double sum_m2 = 0;
    for (std::size_t k = 0; k < 3; ++k) sum_m2 += part[k] * part[k] * variance_along(*points_[k], normal_);
    // A chord of a curve is off by curvature / 2 times the distances from its ends.
    const double bend_m = sigma_bend_per_m / 2 * part[2] * (1 - part[2]) * side_b_m_.squaredNorm();
    return sum_m2 + bend_m * bend_m;
}

bool Triangle::agrees_with(const Feature& fourth, double sigma_bend_per_m) const {
    const Eigen::Vector3d p_m = fourth.p_base_m.cast<double>();
    const double off_m = normal_.dot(p_m - corner_m_);
    return off_m * off_m < agrees_sigmas * agrees_sigmas *
                               (variance_m2(p_m, sigma_bend_per_m) + variance_along(fourth, normal_));
}

std::array<Eigen::Vector3d, 3> Triangle::turned_by() const {
    std::array<Eigen::Vector3d, 3> turned;
    for (std::size_t k = 0; k < 3; ++k)
        turned[k] = std::sqrt(variance_along(*points_[k], normal_)) * slopes_[k];
    return turned;
}

}  // namespace loopline::lidar_odometry
