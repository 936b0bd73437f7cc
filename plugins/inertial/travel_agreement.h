/// Do the accelerometers feel what the odometry drives: speeding up ahead, and curves to the side? That tells
/// the yaw at which an IMU is mounted, of which gravity knows nothing.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "api/pose2.h"
#include "inertial/rate_on_grid.h"
#include "inertial/stretches.h"

namespace loopline::inertial {

/// Sums over cells of time. a: acceleration by the odometry, (dv/dt, v omega), along and across the vehicle;
/// f: mean specific force, axes of the vehicle as the log has them.
struct TravelSums {
    double n = 0, aa = 0;
    Eigen::Vector2d a = Eigen::Vector2d::Zero();
    Eigen::Vector3d f = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 3, 2> fa = Eigen::Matrix<double, 3, 2>::Zero();

    void add(const Eigen::Vector2d& a_mps2, const Eigen::Vector3d& f_mps2);
    void operator+=(const TravelSums& more);
};

/// The yaw of the IMU's x axis (as the log has it) on the vehicle.
struct MountYaw {
    double yaw_rad = 0;
    double sigma_rad = 0;  ///< by the scatter from stretch to stretch
    int stretches = 0;
    double gain = 0;  ///< accelerations felt for one driven: below 1 where the odometry is noisy
};

class TravelAgreement {
 public:
    TravelAgreement();
    void add_imu(StampNs stamp_ns, const Eigen::Vector3d& specific_force_base_mps2);
    void add_odometry(StampNs stamp_ns, const Pose2& T_odom_base);
    /// `righting` turns what the log takes for the vehicle's axes upright. None with fewer than three
    /// stretches of ten seconds, or without any acceleration.
    std::optional<MountYaw> mount_yaw(const Eigen::Matrix3d& righting) const;

 private:
    void compare();

    RateOnGrid<3> force_;     ///< rate of the integral of the force: its mean
    RateOnGrid<2> odometry_;  ///< of (way, heading)
    std::optional<StampNs> force_stamp_ns_;
    Eigen::Vector3d force_mps2_, force_integral_mps_ = Eigen::Vector3d::Zero();
    std::optional<Pose2> last_pose_;
    Eigen::Vector2d way_and_heading_ = Eigen::Vector2d::Zero();
    Stretches<TravelSums> stretches_;
};

}  // namespace loopline::inertial
