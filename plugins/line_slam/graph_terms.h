/// What ties poses and lines in least squares: residuals' values with their Jacobians to plain coordinates.
#pragma once

#include "line_slam/line_observation.h"

namespace loopline::line_slam {

/// The motion from one pose to the next.
struct BetweenTerm {
    Pose2 T_previous_pose;
    Eigen::Matrix3d to_previous, to_pose;  ///< of its (x, y, phi) to those of the poses
};
BetweenTerm between_term(const Pose2& previous, const Pose2& pose);

/// A line as seen from a pose, predicted minus observed.
struct LineTerm {
    Eigen::Vector2d residual;
    Matrix23 to_pose;         ///< to (x, y, phi)
    Eigen::Matrix2d to_line;  ///< to (rho, alpha)
};
LineTerm line_term(const Pose2& pose, const PlanarLine& line, const PlanarLine& observed_base);

}  // namespace loopline::line_slam
