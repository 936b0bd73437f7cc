/// Error-state Kalman filter of the vehicle's pose on the Earth: an odometry's motion predicts, fixes
/// correct. Rows C6, C7.
#pragma once

#include <Eigen/Core>

#include "fusion/fix_noise.h"
#include "fusion/motion.h"

namespace loopline::fusion {

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// What is known at a moment.
struct EarthState {
    Pose3 T_enu_base;
    Eigen::Vector3d fix_error_m = Eigen::Vector3d::Zero();  ///< slow error of the receiver's positions, ENU
    /// Of shift and turn along ENU about the vehicle, and of fix_error_m.
    Matrix9d covariance = Matrix9d::Zero();
};

/// With an error put into it; and what error leads from one to the other.
EarthState moved_by(const EarthState& state, const Vector9d& error);
Vector9d difference(const EarthState& to, const EarthState& from);

/// The state after a motion, without a fix; `F`, if given: what an error became.
EarthState predict(const EarthState& state, const Motion& motion, double fix_correlation_s,
                   const Eigen::Vector3d& fix_correlated_m, Matrix9d* F = nullptr);

/// The slow error of another kind of fix has nothing to do with that before.
EarthState with_new_fix_error(const EarthState& state, const Eigen::Vector3d& correlated_m,
                              Matrix9d* F = nullptr);

/// Innovation of a measurement, its covariance, and how the state's error enters it.
template <int rows>
struct Innovation {
    Eigen::Matrix<double, rows, 1> off;
    Eigen::Matrix<double, rows, rows> covariance;
    Eigen::Matrix<double, rows, 9> H;
    /// Normalised square: chi-square with `rows` degrees of freedom if all is as thought.
    double square() const { return off.dot(covariance.ldlt().solve(off)); }
};

/// A fix's antenna place, at a time at which the vehicle is at T_base_then seen from the state.
Innovation<3> innovation_of_place(const EarthState& state, const Pose3& T_base_then,
                                  const Eigen::Vector3d& p_base_antenna_m, const Eigen::Vector3d& p_enu_m,
                                  const Eigen::Vector3d& white_m);

/// A velocity over ground by Doppler shifts. `v_base_mps`: of the antenna along the vehicle's axes, by the
/// motion.
Innovation<2> innovation_of_velocity(const EarthState& state, const Pose3& T_base_then,
                                     const Eigen::Vector3d& v_base_mps, const Eigen::Vector2d& v_enu_mps,
                                     double sigma_mps);

template <int rows>
EarthState updated(const EarthState& state, const Innovation<rows>& innovation) {
    const Eigen::Matrix<double, 9, rows> PHt = state.covariance * innovation.H.transpose();
    const Eigen::Matrix<double, 9, rows> K = innovation.covariance.ldlt().solve(PHt.transpose()).transpose();
    EarthState after = moved_by(state, K * innovation.off);
    // Joseph's form: symmetric and positive whatever the rounding.
    const Matrix9d left = Matrix9d::Identity() - K * innovation.H;
    const Eigen::Matrix<double, rows, rows> R =
        innovation.covariance - innovation.H * state.covariance * innovation.H.transpose();
    after.covariance = left * state.covariance * left.transpose() + K * R * K.transpose();
    return after;
}

}  // namespace loopline::fusion
