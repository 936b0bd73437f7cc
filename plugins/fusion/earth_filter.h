/// Error-state Kalman filter of the vehicle's pose on the Earth: the motions of an odometry and of wheels
/// predict, fixes correct. Rows C6, C7.
#pragma once

#include <Eigen/Core>

#include "api/dense_algebra.h"
#include "fusion/motion.h"
#include "fusion/wheel_motion.h"
#include "gnss/fix_noise.h"

namespace loopline::fusion {

/// Errors of a state: shift and turn along ENU about the vehicle, slow error of the fixes, lasting errors of
/// the wheels, place of the antenna.
constexpr int fix_errors_at = 6, wheel_errors_at = 9, antenna_at = wheel_errors_at + wheel_error_count,
              state_errors = antenna_at + 3;
using StateVector = Eigen::Matrix<double, state_errors, 1>;
using StateMatrix = Eigen::Matrix<double, state_errors, state_errors>;

/// What is known at a moment.
struct EarthState {
    Pose3 T_enu_base;
    Eigen::Vector3d fix_error_m = Eigen::Vector3d::Zero();  ///< slow error of the receiver's positions, ENU
    WheelErrors wheel_errors = WheelErrors::Zero();         ///< by WheelError
    Eigen::Vector3d antenna_off_m =
        Eigen::Vector3d::Zero();  ///< of the antenna from where it is said to be, base
    StateMatrix covariance = StateMatrix::Zero();
};

/// With an error put into it; and what error leads from one to the other.
EarthState moved_by(const EarthState& state, const StateVector& error);
StateVector difference(const EarthState& to, const EarthState& from);

/// A state and the motion that follows it, (shift, turn) along the vehicle's axes, known together: wheels
/// make their lasting errors part of the motion, and two who tell the same motion tell these errors.
struct StateAndMotion {
    static constexpr int errors = state_errors + 6;
    using Matrix = Eigen::Matrix<double, errors, errors>;
    EarthState state;
    Pose3 T_from_to;
    Matrix covariance = Matrix::Zero();  ///< that of the state included

    Matrix6d of_motion() const { return covariance.bottomRightCorner<6, 6>(); }
};

/// By an odometry in space, which has nothing to do with the state.
StateAndMotion with_odometry(const EarthState& state, const Motion& motion);
/// By wheels alone.
StateAndMotion with_wheels(const EarthState& state, const Twist2& told, const WheelNoise& noise);

/// Wheels beside an odometry: shift forward and to the left, and turn, of the same motion.
struct WheelInnovation {
    Eigen::Vector3d off;
    Eigen::Matrix3d covariance, noise;
    Eigen::Matrix<double, 3, StateAndMotion::errors> H;
    double square() const { return squared_in_sigmas(off, covariance); }
};
WheelInnovation innovation_of_wheels(const StateAndMotion& both, const Twist2& told, const WheelNoise& noise);
StateAndMotion updated(const StateAndMotion& both, const WheelInnovation& innovation);

/// The slow error of fixes, as long as they are of one kind.
struct FixErrorProcess {
    double correlation_s = 1;
    Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
};

/// The state after the motion, and its covariance with the one before.
struct Carried {
    EarthState after;
    StateMatrix before_and_after;
};
Carried carry(const StateAndMotion& both, double duration_s, const FixErrorProcess& fixes,
              const WheelNoise& wheels);

/// The slow error of another kind of fix has nothing to do with that before.
Carried with_new_fix_error(const EarthState& state, const Eigen::Vector3d& sigma_m);

/// Innovation of a measurement, its covariance, and how the state's error enters it.
template <int rows>
struct Innovation {
    Eigen::Matrix<double, rows, 1> off;
    Eigen::Matrix<double, rows, rows> covariance;
    Eigen::Matrix<double, rows, state_errors> H;
    /// Normalised square: chi-square with `rows` degrees of freedom if all is as thought.
    double square() const { return squared_in_sigmas(off, covariance); }
};

/// A fix's antenna place, at a time at which the vehicle is at T_base_then seen from the state.
Innovation<3> innovation_of_place(const EarthState& state, const Pose3& T_base_then,
                                  const Eigen::Vector3d& p_base_antenna_m, const Eigen::Vector3d& p_enu_m,
                                  const Eigen::Vector3d& white_m);

/// A velocity over ground by Doppler shifts. `v_base_mps`: of the antenna along the vehicle's axes, by the
/// motion; if wheels told that, their scale enters.
Innovation<2> innovation_of_velocity(const EarthState& state, const Pose3& T_base_then,
                                     const Eigen::Vector3d& v_base_mps, bool by_wheels,
                                     const Eigen::Vector2d& v_enu_mps, double sigma_mps);

/// What the odometry's frame says is upright: `up_base`, of length 1, along the vehicle's axes. The
/// covariance is of the turn about east and north by which it errs.
Innovation<2> innovation_of_upright(const EarthState& state, const Eigen::Vector3d& up_base,
                                    const Eigen::Matrix2d& covariance_rad2);

/// Of 2 or 3 rows.
template <int rows>
EarthState updated(const EarthState& state, const Innovation<rows>& innovation);

}  // namespace loopline::fusion
