/// Spatial poses with covariance as MRPT's observation for it, and back.
#pragma once

#include <mrpt/obs/CObservationRobotPose.h>

#include <string>

#include "api/pose3.h"

namespace loopline {

/// `covariance` is of (shift, turn about x, y, z) along the axes of the map, about the vehicle; MRPT's is of
/// (x y z yaw pitch roll), and has no meaning where the vehicle stands upright on its nose.
mrpt::obs::CObservationRobotPose::Ptr pose_observation(const std::string& label,
                                                       const mrpt::Clock::time_point& timestamp,
                                                       const Pose3& T_map_base, const Matrix6d& covariance);

struct PoseWithCovariance {
    Pose3 T_map_base;
    Matrix6d covariance = Matrix6d::Zero();  ///< as above
};

/// For a checkpoint.
template <class Archive>
void fields(Archive& archive, PoseWithCovariance& pose) {
    archive(pose.T_map_base, pose.covariance);
}

PoseWithCovariance pose_of(const mrpt::obs::CObservationRobotPose& observation);

/// What covariance the way between two poses adds, of (shift, turn) along the vehicle's axes at the first,
/// about the vehicle at the second: an odometry's errors add up. No direction has less than none.
Matrix6d added_covariance(const PoseWithCovariance& from, const PoseWithCovariance& to);

}  // namespace loopline
