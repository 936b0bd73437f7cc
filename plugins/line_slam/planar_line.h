/// Directed straight lines of the plane, and what one scan saw of them.
///
/// A line is x cos(alpha) + y sin(alpha) = rho. Its normal points away from the side that it was seen from,
/// so the two faces of a thin wall are two lines, and (rho, alpha), (-rho, alpha + pi) never stand for the
/// same one: rho may have any sign outside of the sensor's own frame.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "api/pose2.h"

namespace loopline::line_slam {

/// z x v: v turned left by 90 degrees.
inline Eigen::Vector2d turned_left(const Eigen::Vector2d& v) {
    return {-v.y(), v.x()};
}

struct PlanarLine {
    double rho_m = 0;
    double alpha_rad = 0;

    Eigen::Vector2d normal() const { return {std::cos(alpha_rad), std::sin(alpha_rad)}; }
    /// Direction of growing coordinate along the line: the normal turned left.
    Eigen::Vector2d tangent() const { return {-std::sin(alpha_rad), std::cos(alpha_rad)}; }
    /// > 0 beyond the line, < 0 on the side that it is seen from.
    double signed_distance_m(const Eigen::Vector2d& p_m) const { return normal().dot(p_m) - rho_m; }
    double along_m(const Eigen::Vector2d& p_m) const { return tangent().dot(p_m); }
    Eigen::Vector2d point_m(double along) const { return rho_m * normal() + along * tangent(); }
};

/// The line, given in frame b, in frame a.
inline PlanarLine transformed(const Pose2& T_a_b, const PlanarLine& line_b) {
    PlanarLine line_a;
    line_a.alpha_rad = wrap_to_pi(line_b.alpha_rad + T_a_b.phi_rad);
    line_a.rho_m = line_b.rho_m + line_a.normal().dot(T_a_b.translation());
    return line_a;
}

/// A stretch of a line, by the coordinate along its tangent.
struct Extent {
    double from_m = 0;
    double to_m = 0;

    static Extent of(const PlanarLine& line, const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m) {
        const double a = line.along_m(a_m), b = line.along_m(b_m);
        return {std::min(a, b), std::max(a, b)};
    }
    double length_m() const { return to_m - from_m; }
    /// Length of the common stretch; negative: minus the gap between the two.
    double overlap_m(const Extent& other) const {
        return std::min(to_m, other.to_m) - std::max(from_m, other.from_m);
    }
    void extend(const Extent& other) {
        from_m = std::min(from_m, other.from_m);
        to_m = std::max(to_m, other.to_m);
    }
};

/// A wall as one scan saw it, in the frame of the vehicle's base.
struct LineObservation {
    PlanarLine line;                                       ///< normal away from the sensor
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (rho, alpha): m^2, m rad, rad^2
    Eigen::Matrix2d wall_covariance =
        Eigen::Matrix2d::Zero();  ///< the wall's own part in it: the next scans repeat it
    Eigen::Matrix2d surplus =
        Eigen::Matrix2d::Zero();  ///< to be added where each scan counts as news of its own
    Eigen::Vector2d start_m = Eigen::Vector2d::Zero();
    Eigen::Vector2d end_m = Eigen::Vector2d::Zero();

    double length_m() const { return (end_m - start_m).norm(); }
    Eigen::Vector2d middle_m() const { return 0.5 * (start_m + end_m); }
};

}  // namespace loopline::line_slam
