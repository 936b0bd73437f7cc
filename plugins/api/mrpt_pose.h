/// Spatial poses from MRPT's.
#pragma once

#include <mrpt/poses/CPose3D.h>

#include "api/pose3.h"

namespace loopline {

inline Pose3 pose3_from_mrpt(const mrpt::poses::CPose3D& pose) {
    const Eigen::Matrix3d rotation = pose.getRotationMatrix().asEigen();
    return {{pose.x(), pose.y(), pose.z()}, Eigen::Quaterniond(rotation)};
}

}  // namespace loopline
