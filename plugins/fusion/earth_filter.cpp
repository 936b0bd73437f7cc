#include "fusion/earth_filter.h"

#include <cmath>

namespace loopline::fusion {

using inertial::carried_along;
using inertial::cross_matrix;
using inertial::exp_so3;
using inertial::log_so3;
using inertial::turned_both;

namespace {

/// Of one of the odometry's motions, beside what adds up: each of its poses errs by itself, and the next
/// motion makes up for it.
double own_variance(double told_variance, int row) {
    constexpr double own_m = 0.003, own_rad = 0.01 * M_PI / 180, tells_nothing = 1;
    const double own = row < 3 ? own_m : own_rad;
    return told_variance < tells_nothing ? own * own : 0;
}

/// From the errors of a state and of its motion to those of the state after it: the identity but for the
/// pose, which the motion carries on, and for the slow error of the fixes, which fades.
struct Transition {
    Matrix6d by_pose, by_motion;
    double keeps;

    /// P F'.
    Eigen::MatrixXd from_right(MatrixIn P) const {
        Eigen::MatrixXd PFt = P.leftCols<state_errors>();
        PFt.leftCols<6>() =
            product(P.leftCols<6>(), by_pose.transpose()) + product(P.rightCols<6>(), by_motion.transpose());
        PFt.middleCols<3>(fix_errors_at) *= keeps;
        return PFt;
    }
};

}  // namespace

EarthState moved_by(const EarthState& state, const StateVector& error) {
    EarthState moved = state;
    moved.T_enu_base.translation_m += error.head<3>();
    moved.T_enu_base.rotation = (exp_so3(error.segment<3>(3)) * state.T_enu_base.rotation).normalized();
    moved.fix_error_m += error.segment<3>(fix_errors_at);
    moved.wheel_errors += error.segment<wheel_error_count>(wheel_errors_at);
    moved.antenna_off_m += error.segment<3>(antenna_at);
    return moved;
}

StateVector difference(const EarthState& to, const EarthState& from) {
    StateVector error;
    error << to.T_enu_base.translation_m - from.T_enu_base.translation_m,
        log_so3(to.T_enu_base.rotation * from.T_enu_base.rotation.conjugate()),
        to.fix_error_m - from.fix_error_m, to.wheel_errors - from.wheel_errors,
        to.antenna_off_m - from.antenna_off_m;
    return error;
}

StateAndMotion with_odometry(const EarthState& state, const Motion& motion) {
    StateAndMotion both{state, motion.T_from_to};
    both.covariance.topLeftCorner<state_errors, state_errors>() = state.covariance;
    both.covariance.bottomRightCorner<6, 6>() = motion.covariance;
    return both;
}

StateAndMotion with_wheels(const EarthState& state, const Twist2& told, const WheelNoise& noise) {
    const ByWheelErrors J = by_wheel_errors(told, state.wheel_errors, told.turn_rad);
    const auto P = state.covariance.middleCols<wheel_error_count>(wheel_errors_at);
    StateAndMotion both{state, in_space(corrected(told, state.wheel_errors))};
    both.covariance.topLeftCorner<state_errors, state_errors>() = state.covariance;
    both.covariance.topRightCorner<state_errors, 6>() = P * J.transpose();
    both.covariance.bottomLeftCorner<6, state_errors>() = J * P.transpose();
    both.covariance.bottomRightCorner<6, 6>() =
        propagated(J, P.middleRows<wheel_error_count>(wheel_errors_at)) + noise_of(told, noise);
    return both;
}

WheelInnovation innovation_of_wheels(const StateAndMotion& both, const Twist2& told,
                                     const WheelNoise& noise) {
    constexpr int told_rows[] = {0, 1, 5};
    const WheelErrors& errors = both.state.wheel_errors;
    const double turn_rad = log_so3(both.T_from_to.rotation).z();
    const Pose3 T_by_wheels = in_space(corrected(told, errors, turn_rad));
    Eigen::Matrix<double, 6, 1> off;
    off << T_by_wheels.translation_m - both.T_from_to.translation_m,
        log_so3(T_by_wheels.rotation * both.T_from_to.rotation.conjugate());
    const ByWheelErrors J = by_wheel_errors(told, errors, turn_rad);
    const Matrix6d R = noise_of(told, noise);
    WheelInnovation innovation;
    innovation.H.setZero();
    innovation.noise.setZero();
    for (int k = 0; k < 3; ++k) {
        const int row = told_rows[k];
        innovation.off[k] = off[row];
        innovation.H.block<1, wheel_error_count>(k, wheel_errors_at) = -J.row(row);
        innovation.H(k, state_errors + row) = 1;
        innovation.noise(k, k) = R(row, row) + own_variance(both.of_motion()(row, row), row);
    }
    innovation.covariance = propagated(innovation.H, both.covariance) + innovation.noise;
    return innovation;
}

template <int rows>
EarthState updated(const EarthState& state, const Innovation<rows>& innovation) {
    const Eigen::MatrixXd K = kalman_gain(state.covariance, innovation.H, innovation.covariance);
    EarthState after = moved_by(state, product(K, innovation.off));
    const Eigen::Matrix<double, rows, rows> R =
        innovation.covariance - propagated(innovation.H, state.covariance);
    after.covariance = updated_covariance(state.covariance, K, innovation.H, R);
    return after;
}

template EarthState updated(const EarthState&, const Innovation<2>&);
template EarthState updated(const EarthState&, const Innovation<3>&);

StateAndMotion updated(const StateAndMotion& both, const WheelInnovation& innovation) {
    const Eigen::MatrixXd K = kalman_gain(both.covariance, innovation.H, innovation.covariance);
    const Eigen::Matrix<double, StateAndMotion::errors, 1> error = product(K, innovation.off);
    StateAndMotion after;
    after.state = moved_by(both.state, error.head<state_errors>());
    after.T_from_to.translation_m = both.T_from_to.translation_m + error.segment<3>(state_errors);
    after.T_from_to.rotation = (exp_so3(error.tail<3>()) * both.T_from_to.rotation).normalized();
    after.covariance = updated_covariance(both.covariance, K, innovation.H, innovation.noise);
    after.state.covariance = after.covariance.topLeftCorner<state_errors, state_errors>();
    return after;
}

Carried carry(const StateAndMotion& both, double duration_s, const FixErrorProcess& fixes,
              const WheelNoise& wheels) {
    const EarthState& before = both.state;
    Carried carried{before, {}};
    EarthState& after = carried.after;
    after.T_enu_base = before.T_enu_base * both.T_from_to;
    const double keeps = std::exp(-duration_s / fixes.correlation_s);
    after.fix_error_m *= keeps;

    const Transition F{carried_along(after.T_enu_base.translation_m - before.T_enu_base.translation_m),
                       turned_both(before.T_enu_base.rotation), keeps};
    const Eigen::MatrixXd PFt = F.from_right(both.covariance);
    carried.before_and_after = PFt.topRows<state_errors>();
    after.covariance = F.from_right(PFt.transpose());
    after.covariance.diagonal().segment<3>(fix_errors_at) += (1 - keeps * keeps) * fixes.sigma_m.cwiseAbs2();
    after.covariance.diagonal().segment<wheel_error_count>(wheel_errors_at) +=
        both.T_from_to.translation_m.norm() / 1000 * wheels.drift_km.cwiseAbs2();
    return carried;
}

Carried with_new_fix_error(const EarthState& state, const Eigen::Vector3d& sigma_m) {
    Carried carried{state, state.covariance};
    EarthState& after = carried.after;
    after.fix_error_m.setZero();
    after.covariance.middleCols<3>(fix_errors_at).setZero();
    after.covariance.middleRows<3>(fix_errors_at).setZero();
    after.covariance.diagonal().segment<3>(fix_errors_at) = sigma_m.cwiseAbs2();
    carried.before_and_after.middleCols<3>(fix_errors_at).setZero();
    return carried;
}

Innovation<3> innovation_of_place(const EarthState& state, const Pose3& T_base_then,
                                  const Eigen::Vector3d& p_base_antenna_m, const Eigen::Vector3d& p_enu_m,
                                  const Eigen::Vector3d& white_m) {
    const Eigen::Vector3d arm_m =
        state.T_enu_base.rotation * (T_base_then * (p_base_antenna_m + state.antenna_off_m));
    Innovation<3> innovation;
    innovation.off = p_enu_m - (state.T_enu_base.translation_m + arm_m + state.fix_error_m);
    innovation.H << Eigen::Matrix3d::Identity(), -cross_matrix(arm_m), Eigen::Matrix3d::Identity(),
        Eigen::Matrix<double, 3, wheel_error_count>::Zero(),
        (state.T_enu_base.rotation * T_base_then.rotation).toRotationMatrix();
    innovation.covariance = propagated(innovation.H, state.covariance);
    innovation.covariance.diagonal() += white_m.cwiseAbs2();
    return innovation;
}

Innovation<2> innovation_of_velocity(const EarthState& state, const Pose3& T_base_then,
                                     const Eigen::Vector3d& v_base_mps, bool by_wheels,
                                     const Eigen::Vector2d& v_enu_mps, double sigma_mps) {
    const Eigen::Vector3d expected = state.T_enu_base.rotation * (T_base_then.rotation * v_base_mps);
    Innovation<2> innovation;
    innovation.off = v_enu_mps - expected.head<2>();
    innovation.H.setZero();
    innovation.H.middleCols<3>(3) = -cross_matrix(expected).topRows<2>();
    if (by_wheels)
        innovation.H.col(wheel_errors_at + way_scale) =
            expected.head<2>() / (1 + state.wheel_errors[way_scale]);
    innovation.covariance = propagated(innovation.H, state.covariance);
    innovation.covariance.diagonal().array() += sigma_mps * sigma_mps;
    return innovation;
}

Innovation<2> innovation_of_upright(const EarthState& state, const Eigen::Vector3d& up_base,
                                    const Eigen::Matrix2d& covariance_rad2) {
    const Eigen::Vector3d up_enu = state.T_enu_base.rotation * up_base;
    Innovation<2> innovation;
    innovation.off = -up_enu.head<2>();
    innovation.H.setZero();
    innovation.H.middleCols<3>(3) = -cross_matrix(up_enu).topRows<2>();
    // A turn d moves what is upright by (d_y, -d_x).
    Eigen::Matrix2d by_turn;
    by_turn << 0, 1, -1, 0;
    innovation.covariance = propagated(innovation.H, state.covariance) + propagated(by_turn, covariance_rad2);
    return innovation;
}

}  // namespace loopline::fusion
