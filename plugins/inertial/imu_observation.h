/// Readings of an IMU from MRPT's observations.
#pragma once

#include <mrpt/obs/CObservationIMU.h>

#include <optional>

#include "inertial/imu_sample.h"

namespace loopline::inertial {

/// Rates and specific forces along the sensor's axes, and its attitude on the vehicle by `sensorPose`;
/// nothing if any of the six numbers is not in the observation. They are those at the sensor's own place:
/// `p_base_imu_m()` says where that is.
std::optional<ImuReading> reading_from_mrpt(const mrpt::obs::CObservationIMU& observation, StampNs stamp_ns);

/// Where the sensor is on the vehicle.
Eigen::Vector3d p_base_imu_m(const mrpt::obs::CObservationIMU& observation);

}  // namespace loopline::inertial
