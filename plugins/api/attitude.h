/// Rotations by yaw, pitch and roll, as MRPT has them.
#pragma once

#include <Eigen/Geometry>

namespace loopline {

/// Rz(yaw) Ry(pitch) Rx(roll): from the body's axes to those that it stands in.
inline Eigen::Quaterniond attitude(double yaw_rad, double pitch_rad, double roll_rad) {
    return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX());
}

}  // namespace loopline
