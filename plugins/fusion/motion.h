/// How the vehicle moved from one moment to the next, as an odometry tells it.
#pragma once

#include "api/pose3_motion.h"
#include "inertial/pose_error.h"

namespace loopline::fusion {

struct Motion {
    Pose3 T_from_to;
    /// Of (shift, turn) of T_from_to, along the vehicle's axes at `from`, about the vehicle at `to`.
    Matrix6d covariance = Matrix6d::Zero();
};

}  // namespace loopline::fusion
