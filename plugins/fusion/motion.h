/// How the vehicle moved from one moment to the next, as an odometry tells it, and what that does to the
/// error of a pose.
#pragma once

#include "api/pose3.h"
#include "api/pose3_motion.h"
#include "inertial/rotation_vector.h"

namespace loopline::fusion {

struct Motion {
    Pose3 T_from_to;
    /// Of (shift, turn) of T_from_to, along the vehicle's axes at `from`, about the vehicle at `to`.
    Matrix6d covariance = Matrix6d::Zero();
};

/// Turns (shift, turn) from the vehicle's axes to those that it stands in.
inline Matrix6d turned_both(const Eigen::Quaterniond& rotation) {
    Matrix6d R = Matrix6d::Zero();
    R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = rotation.toRotationMatrix();
    return R;
}

/// What an error (shift, turn) of a pose, along the axes that it stands in and about the vehicle, becomes
/// after a way: the turn carries what lies ahead.
inline Matrix6d carried_along(const Eigen::Vector3d& way_m) {
    Matrix6d F = Matrix6d::Identity();
    F.topRightCorner<3, 3>() = -inertial::cross_matrix(way_m);
    return F;
}

}  // namespace loopline::fusion
