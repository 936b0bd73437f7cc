/// The pose of a sensor as observations have it.
#pragma once

#include <mrpt/poses/CPose3D.h>

#include "api/pose3.h"

namespace loopline::simulation {

inline mrpt::poses::CPose3D mrpt_pose(const Pose3& pose) {
    const auto& q = pose.rotation;
    return mrpt::poses::CPose3D(mrpt::math::CQuaternionDouble(q.w(), q.x(), q.y(), q.z()),
                                pose.translation_m.x(), pose.translation_m.y(), pose.translation_m.z());
}

}  // namespace loopline::simulation
