#include "fusion/earth_filter.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace loopline::fusion {

using inertial::cross_matrix;
using inertial::exp_so3;
using inertial::log_so3;

EarthState moved_by(const EarthState& state, const Vector9d& error) {
    EarthState moved = state;
    moved.T_enu_base.translation_m += error.head<3>();
    moved.T_enu_base.rotation = (exp_so3(error.segment<3>(3)) * state.T_enu_base.rotation).normalized();
    moved.fix_error_m += error.tail<3>();
    return moved;
}

Vector9d difference(const EarthState& to, const EarthState& from) {
    Vector9d error;
    error << to.T_enu_base.translation_m - from.T_enu_base.translation_m,
        log_so3(to.T_enu_base.rotation * from.T_enu_base.rotation.conjugate()),
        to.fix_error_m - from.fix_error_m;
    return error;
}

EarthState predict(const EarthState& state, const Motion& motion, double fix_correlation_s,
                   const Eigen::Vector3d& fix_correlated_m, Matrix9d* F_out) {
    EarthState next = state;
    next.T_enu_base = state.T_enu_base * motion.T_from_to;
    const double keeps = std::exp(-motion.duration_s() / fix_correlation_s);
    next.fix_error_m *= keeps;

    Matrix9d F = Matrix9d::Identity();
    F.topLeftCorner<6, 6>() = carried_along(next.T_enu_base.translation_m - state.T_enu_base.translation_m);
    F.bottomRightCorner<3, 3>() *= keeps;
    const Matrix6d R = turned_both(state.T_enu_base.rotation);
    next.covariance = F * state.covariance * F.transpose();
    next.covariance.topLeftCorner<6, 6>() += R * motion.covariance * R.transpose();
    next.covariance.bottomRightCorner<3, 3>().diagonal() +=
        (1 - keeps * keeps) * fix_correlated_m.cwiseAbs2();
    if (F_out != nullptr) *F_out = F;
    return next;
}

EarthState with_new_fix_error(const EarthState& state, const Eigen::Vector3d& correlated_m, Matrix9d* F_out) {
    EarthState next = state;
    Matrix9d F = Matrix9d::Identity();
    F.bottomRightCorner<3, 3>().setZero();
    next.fix_error_m.setZero();
    next.covariance = F * state.covariance * F.transpose();
    next.covariance.bottomRightCorner<3, 3>().diagonal() = correlated_m.cwiseAbs2();
    if (F_out != nullptr) *F_out = F;
    return next;
}

Innovation<3> innovation_of_place(const EarthState& state, const Pose3& T_base_then,
                                  const Eigen::Vector3d& p_base_antenna_m, const Eigen::Vector3d& p_enu_m,
                                  const Eigen::Vector3d& white_m) {
    const Eigen::Vector3d arm_m = state.T_enu_base.rotation * (T_base_then * p_base_antenna_m);
    Innovation<3> innovation;
    innovation.off = p_enu_m - (state.T_enu_base.translation_m + arm_m + state.fix_error_m);
    innovation.H << Eigen::Matrix3d::Identity(), -cross_matrix(arm_m), Eigen::Matrix3d::Identity();
    innovation.covariance = innovation.H * state.covariance * innovation.H.transpose();
    innovation.covariance.diagonal() += white_m.cwiseAbs2();
    return innovation;
}

Innovation<2> innovation_of_velocity(const EarthState& state, const Pose3& T_base_then,
                                     const Eigen::Vector3d& v_base_mps, const Eigen::Vector2d& v_enu_mps,
                                     double sigma_mps) {
    const Eigen::Vector3d expected = state.T_enu_base.rotation * (T_base_then.rotation * v_base_mps);
    Innovation<2> innovation;
    innovation.off = v_enu_mps - expected.head<2>();
    innovation.H.setZero();
    innovation.H.middleCols<3>(3) = -cross_matrix(expected).topRows<2>();
    innovation.covariance = innovation.H * state.covariance * innovation.H.transpose();
    innovation.covariance.diagonal().array() += sigma_mps * sigma_mps;
    return innovation;
}

}  // namespace loopline::fusion
