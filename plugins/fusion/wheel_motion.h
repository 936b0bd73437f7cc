/// What wheels tell of a motion, and how they err: by scales that last, which a filter can find, and by
/// noise.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "api/pose3.h"
#include "odometry/twist2.h"

namespace loopline::fusion {

/// Errors of wheels that last, in the order in which a vector holds them.
enum WheelError {
    way_scale,   ///< the true way is longer by this part: tyres, their pressure, their load
    turn_scale,  ///< the true turn is larger by this part: the track, or wheels that scrub
    bend         ///< and by so many radians a metre: a steering or two wheels that are not quite alike
};

struct WheelNoise {
    /// Of the errors that last: at first, and what they change by after 1 km.
    Eigen::Vector3d first{0.03, 0.05, 0.2 * M_PI / 180}, drift_km{0.001, 0.002, 0.003 * M_PI / 180};
    double along_m = 0.02, across_m = 0.02;     ///< after 1 m; grows with the root of the way
    double turn_rad = 0.1 * M_PI / 180;         ///< after 1 m
    double turn_per_turn_rad = 3 * M_PI / 180;  ///< after one full turn
    double up_m = 0.02,
           tilt_rad = 0.15 * M_PI / 180;  ///< after 1 m, of what wheels tell nothing of: the road
};

/// The motion as wheels have it with errors `errors` taken out, in the plane that the vehicle stands on.
Twist2 corrected(const Twist2& told, const Eigen::Vector3d& errors);
inline Pose3 in_space(const Twist2& twist) {
    return Pose3(exp_se2(twist));
}

/// Derivative of (shift, turn) of in_space(corrected(told, errors)), along the vehicle's axes at its
/// beginning, about the vehicle at its end, by the errors.
Eigen::Matrix<double, 6, 3> by_wheel_errors(const Twist2& told, const Eigen::Vector3d& errors);

/// Covariance of (shift, turn) by the noise.
Matrix6d noise_of(const Twist2& told, const WheelNoise& noise);

}  // namespace loopline::fusion
