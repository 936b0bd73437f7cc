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

/// The same along the sensor's own axes, and how these lie in the vehicle.
struct ImuReading {
    StampNs stamp_ns = 0;
    Eigen::Vector3d omega_imu_radps = Eigen::Vector3d::Zero();
    Eigen::Vector3d specific_force_imu_mps2 = Eigen::Vector3d::Zero();
    Eigen::Matrix3d R_base_imu = Eigen::Matrix3d::Identity();

    ImuSample along_base() const {
        return {stamp_ns, R_base_imu * omega_imu_radps, R_base_imu * specific_force_imu_mps2};
    }
};

}  // namespace loopline::inertial
