/// The rigorous line observation: distance and direction of a map line as the vehicle sees it, with its
/// Jacobians to pose and line. It replaces eq. (11) of Hu, Chen, Zhang 2012, whose foot point from the
/// world's origin is no observable.
///
/// Errors of the pose are invariant ones: T_map_base = Exp(t, theta) T_map_base_estimated, that is
/// p = p^ + t + theta (z x p^), phi = phi^ + theta. Then the motion leaves errors alone, and the
/// observation's Jacobians to pose and line cancel for a motion of the whole map, wherever they are
/// evaluated, if the normal in them is the same every time that the line is seen: that of its first estimate.
/// So the filter gains no heading from its own linearisation.
#pragma once

#include <Eigen/Core>

#include "line_slam/planar_line.h"

namespace loopline::line_slam {

using Matrix23 = Eigen::Matrix<double, 2, 3>;

/// h(x) of (pose, map line): (rho, alpha) in the base frame.
PlanarLine predicted_line(const Pose2& T_map_base, const PlanarLine& line_map);

/// Observed minus predicted, the angle wrapped to (-pi, pi]; the distance is that of the observed foot point
/// along the predicted normal. A scan knows where the seen stretch of a wall is better than how it is turned:
/// with its direction off by d, the distance of its line from here is R cos(d) for a stretch straight ahead
/// at R, and too small on the average of many scans, while the seen stretch is where it should be.
Eigen::Vector2d innovation(const PlanarLine& observed_base, const PlanarLine& predicted_base);

/// Of two lines in one frame, a minus b, where neither is what a scan sees from that frame's origin.
Eigen::Vector2d difference(const PlanarLine& a, const PlanarLine& b);

struct ObservationJacobians {
    Matrix23 pose;         ///< to (t_x, t_y, theta)
    Eigen::Matrix2d line;  ///< to (rho, alpha) of the map line
};
/// `first_normal`: of the line as it was first estimated.
ObservationJacobians observation_jacobians(const Pose2& T_map_base, const PlanarLine& line_map,
                                           const Eigen::Vector2d& first_normal);

struct AugmentationJacobians {
    Matrix23 pose;                ///< of the new map line (rho, alpha) to (t_x, t_y, theta)
    Eigen::Matrix2d observation;  ///< to (rho, alpha) in the base frame
};
/// Of `transformed(T_map_base, observed)`, which has `line_map` as its value.
AugmentationJacobians augmentation_jacobians(const Pose2& T_map_base, const PlanarLine& line_map);

/// Exp(t, theta) T_map_base.
Pose2 corrected(const Pose2& T_map_base, const Eigen::Vector3d& error);

/// d(x, y, phi) / d(t_x, t_y, theta): turns an invariant covariance into that of the coordinates.
Eigen::Matrix3d coordinates_from_error(const Pose2& T_map_base);

/// Adjoint of T: an error (t, theta) on the right of T, as one on its left.
Eigen::Matrix3d adjoint(const Pose2& T);

}  // namespace loopline::line_slam
