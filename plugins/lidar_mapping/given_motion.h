/// The motion between two sweeps by another odometry, in the place of the constant velocity: LOAM's two
/// levels.
#pragma once

#include "lidar_mapping/motion_state.h"

namespace loopline::lidar_mapping {

struct GivenMotion {
    Pose3 T_last_now;        ///< from the middle of the latest sweep of the map to the middle of this one
    Twist3 velocity;         ///< a second, along the vehicle's axes, now
    Twist3 velocity_before;  ///< at the latest sweep
    double velocity_over_s = 0.1;                     ///< the time that the velocity is the mean of
    Matrix6d velocity_covariance = Matrix6d::Zero();  ///< of that mean
    /// Of (shift, turn) of T_last_now, along the vehicle's axes at the latest sweep, about the vehicle now.
    Matrix6d covariance = Matrix6d::Zero();
    double sigma_scale = 0;  ///< of its ways, the same for all: an error of theirs adds up
    bool planar = false;     ///< wheels tell shift x, y and turn z only
};

/// As predict(): the state in the middle of the next sweep, before that is matched. What wheels do not tell
/// goes on as before.
MotionState predict(const MotionState& state, const GivenMotion& given, double duration_s,
                    const MotionNoise& noise);

}  // namespace loopline::lidar_mapping
