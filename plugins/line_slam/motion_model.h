/// Differential drive: what the wheels say about the motion between two scans. Hu, Chen, Zhang 2012, eq.
/// (3)-(6), in MRPT's axes (x, y, phi) instead of the paper's (x, z, alpha).
#pragma once

#include <Eigen/Core>

#include "api/pose2.h"

namespace loopline::line_slam {

/// What is physical about the drive. Noise grows with the square root of the way, as that of a sum of
/// independent slips.
struct DriveParameters {
    double track_width_m = 0.5;         ///< l, distance of the driven wheels
    double odometry_track_width_m = 0;  ///< that the log's poses were reckoned with; 0: the same
    double sigma_wheel_m = 0.03;        ///< of one wheel's travel after 1 m
    double sigma_side_m = 0.06;         ///< of the sideways motion after 1 m
    double sigma_rest_m = 0.0005;       ///< of each, without any motion: resolution of the encoders
    double sigma_scale = 0.05;          ///< how well wheel diameters and track width are known, as a fraction

    double odometry_width_m() const {
        return odometry_track_width_m > 0 ? odometry_track_width_m : track_width_m;
    }
};

/// The control u of eq. (3), as travel instead of speed times interval. A log that has only relative poses
/// may tell of a sideways motion too, which wheels alone can't.
struct WheelTravel {
    double left_m = 0;
    double right_m = 0;
    double side_m = 0;  ///< to the left, along the axle's direction half-way
};

/// What is wrong with the drive's numbers, as fractions: true travel = (1 + left) x measured, true track
/// width = (1 + track) x stated. Real logs bend by degrees a metre from this; it is constant, so that walls
/// can tell it, unlike slip.
struct WheelCalibration {
    double left = 0, right = 0, track = 0;
};

/// The control that takes the vehicle from the old to the new base frame; inverse of `moved`.
WheelTravel wheel_travel(const Pose2& T_old_new, double track_width_m);

/// Eq. (3) from the pose zero: mid-point heading.
Pose2 moved(const WheelTravel& travel, double track_width_m, const WheelCalibration& calibration = {});

struct MotionJacobians {
    Eigen::Matrix3d
        travel;  ///< of `moved` to (left, right, side): the control's Jacobian of eq. (5), old base frame
    Eigen::Matrix3d calibration;  ///< to (left, right, track)
};
MotionJacobians motion_jacobians(const WheelTravel& travel, double track_width_m,
                                 const WheelCalibration& calibration = {});

/// What the wheels ought to say about a motion, as the inverse of `moved`, with Jacobians. An estimator that
/// knows the motion from elsewhere must compare here, in the space of the measurement: noise in the measured
/// turn would otherwise pass for a turn, and for a wrong track width.
struct ExpectedTravel {
    WheelTravel travel;
    Eigen::Matrix3d motion;       ///< of (left, right, side) to (x, y, phi) of the motion
    Eigen::Matrix3d calibration;  ///< to (left, right, track)
};
ExpectedTravel expected_travel(const Pose2& T_old_new, double track_width_m,
                               const WheelCalibration& calibration);

/// Way of the vehicle's middle, whatever its direction.
double mean_way_m(const WheelTravel& travel);

/// Q of eq. (5): covariance of (left, right, side). The two last, above 0, replace `drive.sigma_wheel_m` for
/// one wheel.
Eigen::Matrix3d travel_covariance(const WheelTravel& travel, const DriveParameters& drive,
                                  double sigma_left_m = 0, double sigma_right_m = 0);

/// Motion under one control.
struct MotionPiece {
    WheelTravel travel;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (left, right, side)
};

}  // namespace loopline::line_slam
