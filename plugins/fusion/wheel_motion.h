/// What wheels tell of a motion, and how they err: by scales that last, which a filter can find, and by
/// noise.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "api/pose3.h"
#include "api/twist2.h"

namespace loopline::fusion {

/// Errors of wheels that last, in the order in which a vector holds them.
enum WheelError {
    way_scale,   ///< the true way is longer by this part: tyres, their pressure, their load
    turn_scale,  ///< the true turn is larger by this part: the track, or wheels that scrub
    bend,        ///< and by so many radians a metre: a steering or two wheels that are not quite alike
    one_sided,   ///< a turn to the left is larger by this part, one to the right smaller
    curve        ///< a turn is larger by this times its curvature squared, m^2: steering gear is not linear
};
constexpr int wheel_error_count = 5;
using WheelErrors = Eigen::Matrix<double, wheel_error_count, 1>;
using ByWheelErrors = Eigen::Matrix<double, 6, wheel_error_count>;

struct WheelNoise {
    /// Of the errors that last: at first, and what they change by after 1 km.
    WheelErrors first{0.03, 0.05, 0.2 * M_PI / 180, 0.03, 0.5},
        drift_km{0.001, 0.002, 0.003 * M_PI / 180, 0.002, 0};
    double along_m = 0.02, across_m = 0.02;     ///< after 1 m; grows with the root of the way
    double turn_rad = 0.1 * M_PI / 180;         ///< after 1 m
    double turn_per_turn_rad = 3 * M_PI / 180;  ///< after one full turn
    double up_m = 0.02,
           tilt_rad = 0.15 * M_PI / 180;  ///< after 1 m, of what wheels tell nothing of: the road
};

/// The motion as wheels have it with errors `errors` taken out, in the plane that the vehicle stands on.
/// `turn_rad`: what the errors of a turn grow with, where that is better known than by the wheels themselves.
/// Their noise would look like turns that the vehicle did not make, and the scale of turns too small.
Twist2 corrected(const Twist2& told, const WheelErrors& errors, double turn_rad);
inline Twist2 corrected(const Twist2& told, const WheelErrors& errors) {
    return corrected(told, errors, told.turn_rad);
}
inline Pose3 in_space(const Twist2& twist) {
    return Pose3(exp_se2(twist));
}

/// Derivative of (shift, turn) of in_space(corrected(told, errors)), along the vehicle's axes at its
/// beginning, about the vehicle at its end, by the errors.
ByWheelErrors by_wheel_errors(const Twist2& told, const WheelErrors& errors, double turn_rad);

/// Covariance of (shift, turn) by the noise.
Matrix6d noise_of(const Twist2& told, const WheelNoise& noise);

}  // namespace loopline::fusion
