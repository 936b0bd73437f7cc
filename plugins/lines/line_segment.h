/// A straight wall piece extracted from one scan.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

namespace loopline::lines {

/// The line x cos(alpha) + y sin(alpha) = rho in the sensor frame, rho >= 0, with the beams that support it.
/// Its foot point from the sensor is rho (cos alpha, sin alpha).
struct LineSegment {
    double rho_m = 0;                                      ///< distance of the infinite line from the sensor
    double alpha_rad = 0;                                  ///< direction of its normal, in (-pi, pi]
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (rho, alpha): m^2, m rad, rad^2
    Eigen::Vector2d start_m = Eigen::Vector2d::Zero();     ///< first beam's point, projected on the line
    Eigen::Vector2d end_m = Eigen::Vector2d::Zero();       ///< last beam's point, projected on the line
    std::size_t first_beam = 0;
    std::size_t last_beam =
        0;  ///< inclusive; beams in between may belong to no or another line after a merge
    std::size_t beam_count = 0;  ///< points in the fit
    double rms_m = 0;            ///< of the points' distances from the line

    double length_m() const { return (end_m - start_m).norm(); }
    Eigen::Vector2d foot_point_m() const {
        return {rho_m * std::cos(alpha_rad), rho_m * std::sin(alpha_rad)};
    }
};

using LineSegments = std::vector<LineSegment>;

}  // namespace loopline::lines
