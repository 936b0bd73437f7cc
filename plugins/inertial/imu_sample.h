/// One reading of an inertial measurement unit, along the axes of the vehicle.
#pragma once

#include <Eigen/Core>

#include "api/stamp.h"

namespace loopline::inertial {

struct ImuSample {
    StampNs stamp_ns = 0;
    Eigen::Vector3d omega_base_radps = Eigen::Vector3d::Zero();
    /// What an accelerometer feels: acceleration minus gravity, so (0, 0, +9.8) at rest on level ground.
    Eigen::Vector3d specific_force_base_mps2 = Eigen::Vector3d::Zero();
};

}  // namespace loopline::inertial
