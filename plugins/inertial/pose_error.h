/// What becomes of the error (shift, turn) of a pose, about the vehicle, when the vehicle moves.
#pragma once

#include "api/dense_algebra.h"
#include "api/pose3.h"
#include "inertial/rotation_vector.h"

namespace loopline::inertial {

/// Turns (shift, turn) from the vehicle's axes to those that it stands in.
inline Matrix6d turned_both(const Eigen::Quaterniond& rotation) {
    Matrix6d R = Matrix6d::Zero();
    R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = rotation.toRotationMatrix();
    return R;
}

/// What an error (shift, turn), along the axes that the vehicle stands in and about the vehicle, becomes
/// after a way, about where the vehicle is then: the turn carries what lies ahead.
inline Matrix6d carried_along(const Eigen::Vector3d& way_m) {
    Matrix6d F = Matrix6d::Identity();
    F.topRightCorner<3, 3>() = -cross_matrix(way_m);
    return F;
}

/// Covariance of (shift, turn) along the axes that `from` stands in, after a motion to `to` whose own
/// covariance `of_motion` is along the vehicle's axes at `from`, about the vehicle at `to`.
inline Matrix6d grown(const Matrix6d& covariance, const Pose3& from, const Pose3& to,
                      const Matrix6d& of_motion) {
    const Matrix6d F = carried_along(to.translation_m - from.translation_m), R = turned_both(from.rotation);
    return propagated(F, covariance) + propagated(R, of_motion);
}

}  // namespace loopline::inertial
