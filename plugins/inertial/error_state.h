/// The error of inertial navigation: truth = state (+) error, fifteen numbers, and how they grow.
///
///     p_true = p + dp,   v_true = v + dv,   R_true = Exp(dtheta) R,   bg_true = bg + dbg,   ba_true = ba +
///     dba
///
/// dtheta is in the map frame: its z part is the error of the heading, whatever the vehicle's attitude. Sola
/// 2017, "Quaternion kinematics for the error-state Kalman filter", ch. 7 (global angular errors).
#pragma once

#include "inertial/mechanisation.h"

namespace loopline::inertial {

constexpr int error_size = 15;
using ErrorVector = Eigen::Matrix<double, error_size, 1>;
using ErrorMatrix = Eigen::Matrix<double, error_size, error_size>;

/// Where each part begins; three numbers each.
enum ErrorPart {
    position_error = 0,             ///< m, map frame
    velocity_error = 3,             ///< m/s, map frame
    attitude_error = 6,             ///< rad, map frame
    gyro_bias_error = 9,            ///< rad/s, base frame
    accelerometer_bias_error = 12,  ///< m/s^2, base frame
};

/// White noise as a density, and how the bias walks. Both as in data sheets: the standard deviation after one
/// second.
struct GyroNoise {
    double density_radps_sqrt_hz = 2e-4;  ///< angular random walk: rad after a second
    double bias_walk_radps_sqrt_s = 2e-6;
};
struct AccelerometerNoise {
    double density_mps2_sqrt_hz = 2e-3;  ///< velocity random walk: m/s after a second
    double bias_walk_mps2_sqrt_s = 2e-5;
};
struct ImuNoise {
    GyroNoise gyro;
    AccelerometerNoise accelerometer;
};

/// Phi of one step: error at `to` = Phi * error at `from`, the derivative of Mechanisation::forward() at
/// `state_from`.
ErrorMatrix transition(const NavigationState& state_from, const ImuSample& from, const ImuSample& to);
/// Its inverse, in closed form.
ErrorMatrix inverse_transition(const NavigationState& state_from, const ImuSample& from, const ImuSample& to);

/// Covariance of what noise adds to the error in a step of `duration_s` whose transition is `Phi`.
ErrorMatrix process_noise(const ImuNoise& noise, const ErrorMatrix& Phi, double duration_s);

/// state (+) error: the corrected state.
NavigationState inject(const NavigationState& state, const ErrorVector& error);
/// truth (-) state, so that inject(state, error_between(state, truth)) is the truth.
ErrorVector error_between(const NavigationState& state, const NavigationState& truth);
/// Covariance of the error that is left after inject(): only the attitude part turns.
ErrorMatrix covariance_after_injection(const ErrorMatrix& covariance, const ErrorVector& error);

}  // namespace loopline::inertial
