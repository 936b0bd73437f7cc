/// Measurements that a cart on a floor has: poses from scan matching, wheels, the floor itself. Each is the
/// measurement of the error of a state, for ErrorStateFilter::update().
#pragma once

#include "api/pose3.h"
#include "inertial/error_state_filter.h"
#include "inertial/planar_information.h"

namespace loopline::inertial {

/// Where the IMU is on the vehicle: poses and speeds are of the base, the state is of the IMU.
struct ImuPlace {
    Eigen::Vector3d p_base_imu_m = Eigen::Vector3d::Zero();
};

/// Pose of the base from the state of the IMU.
Pose3 base_pose(const NavigationState& state, const ImuPlace& place);
/// Velocity of the base along its own axes; `omega_base_radps` as read, with its bias.
Eigen::Vector3d base_velocity_mps(const NavigationState& state, const ImuPlace& place,
                                  const Eigen::Vector3d& omega_base_radps);

/// x, y and heading of the base, with their covariance (m, m, rad; map frame).
ErrorMeasurement pose_measurement(const NavigationState& state, const ImuPlace& place,
                                  const Pose2& T_map_base, const Eigen::Matrix3d& covariance);
/// The same along the directions that a matcher knows something of: the others are left alone. No rows if
/// there are none.
ErrorMeasurement pose_measurement(const NavigationState& state, const ImuPlace& place,
                                  const PlanarInformation& pose, double vaguest_sigma = 100);

/// A level floor: the base is at `height_map_m` and does not rise. The unevenness of a floor does not change
/// from one sample to the next: apply this at scans rather than at each reading, or with larger deviations.
struct LevelFloor {
    double height_map_m = 0;
    double sigma_height_m = 0.01;
    double sigma_climb_mps = 0.02;
};
ErrorMeasurement level_floor_measurement(const NavigationState& state, const ImuPlace& place,
                                         const LevelFloor& floor);

/// At a standstill: no velocity.
ErrorMeasurement zero_velocity_measurement(const NavigationState& state, double sigma_mps);

/// Speed of the base along one of its axes: `axis` 0 from the wheels, 1 with speed 0 for wheels that do not
/// slide sideways.
ErrorMeasurement base_speed_measurement(const NavigationState& state, const ImuPlace& place,
                                        const Eigen::Vector3d& omega_base_radps, int axis, double speed_mps,
                                        double sigma_mps);

}  // namespace loopline::inertial
