/// What inertial navigation knows of a vehicle, and what its sensors get wrong.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "api/stamp.h"

namespace loopline::inertial {

/// Pose and velocity of the IMU in the map frame, with the axes of the vehicle (base). The map's z axis
/// points up: roll and pitch are against gravity.
struct NavigationState {
    StampNs stamp_ns = 0;
    Eigen::Quaterniond q_map_base = Eigen::Quaterniond::Identity();  ///< unit
    Eigen::Vector3d v_map_mps = Eigen::Vector3d::Zero();
    Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();          ///< reading minus truth, base axes
    Eigen::Vector3d accelerometer_bias_mps2 = Eigen::Vector3d::Zero();  ///< likewise
};

/// For checkpoints: api/state_archive.h.
template <class Archive>
void fields(Archive& archive, NavigationState& s) {
    archive(s.stamp_ns, s.q_map_base.coeffs(), s.v_map_mps, s.p_map_m, s.gyro_bias_radps,
            s.accelerometer_bias_mps2);
}

}  // namespace loopline::inertial
