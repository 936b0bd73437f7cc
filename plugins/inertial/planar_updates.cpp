#include "inertial/planar_updates.h"

#include "inertial/rotation_vector.h"

namespace loopline::inertial {
namespace {

using PoseRows = Eigen::Matrix<double, 3, error_size>;

/// Derivative of the base's position by the error: p_base = p - R r, and d(R r) = dtheta x R r.
PoseRows position_rows(const NavigationState& state, const ImuPlace& place) {
    PoseRows rows = PoseRows::Zero();
    rows.middleCols<3>(position_error).setIdentity();
    rows.middleCols<3>(attitude_error) = cross_matrix(state.q_map_base * place.p_base_imu_m);
    return rows;
}

/// Derivative of (x, y, heading) of the base by the error. The heading is that of the x axis' projection on
/// the floor: a tilt error turns it where that axis climbs.
PoseRows planar_rows(const NavigationState& state, const ImuPlace& place) {
    PoseRows rows = position_rows(state, place);
    rows.row(2).setZero();
    const Eigen::Vector3d x_axis = state.q_map_base * Eigen::Vector3d::UnitX();
    const double climb = x_axis.z() / x_axis.head<2>().squaredNorm();
    rows.block<1, 3>(2, attitude_error) << -climb * x_axis.x(), -climb * x_axis.y(), 1;
    return rows;
}

Eigen::Vector3d planar_difference(const Pose2& to, const Pose2& from) {
    return {to.x_m - from.x_m, to.y_m - from.y_m, wrap_to_pi(to.phi_rad - from.phi_rad)};
}

/// Derivative of R' v - omega x r by the error.
PoseRows base_velocity_rows(const NavigationState& state, const ImuPlace& place) {
    const Eigen::Matrix3d R_base_map = state.q_map_base.toRotationMatrix().transpose();
    PoseRows rows = PoseRows::Zero();
    rows.middleCols<3>(velocity_error) = R_base_map;
    rows.middleCols<3>(attitude_error) = R_base_map * cross_matrix(state.v_map_mps);
    // The rate is the reading less the bias, and -(w - dbg) x r = -w x r - r x dbg.
    rows.middleCols<3>(gyro_bias_error) = -cross_matrix(place.p_base_imu_m);
    return rows;
}

}  // namespace

Pose3 base_pose(const NavigationState& state, const ImuPlace& place) {
    return {state.p_map_m - state.q_map_base * place.p_base_imu_m, state.q_map_base};
}

Eigen::Vector3d base_velocity_mps(const NavigationState& state, const ImuPlace& place,
                                  const Eigen::Vector3d& omega_base_radps) {
    return state.q_map_base.conjugate() * state.v_map_mps -
           (omega_base_radps - state.gyro_bias_radps).cross(place.p_base_imu_m);
}

ErrorMeasurement pose_measurement(const NavigationState& state, const ImuPlace& place,
                                  const Pose2& T_map_base, const Eigen::Matrix3d& covariance) {
    ErrorMeasurement m(3);
    m.H = planar_rows(state, place);
    m.innovation = planar_difference(T_map_base, base_pose(state, place).planar());
    m.R = covariance;
    return m;
}

ErrorMeasurement pose_measurement(const NavigationState& state, const ImuPlace& place,
                                  const PlanarInformation& pose, double vaguest_sigma) {
    const KnownDirections known = known_directions(pose, vaguest_sigma);
    const PoseRows rows = planar_rows(state, place);
    const Eigen::Vector3d from_state = planar_difference(pose.T_map_base, base_pose(state, place).planar());
    ErrorMeasurement m(known.count);
    for (int i = 0; i < known.count; ++i) {
        const auto& [direction, value, variance] = known.at[i];
        m.H.row(i) = direction.transpose() * rows;
        m.innovation(i) = value + direction.dot(from_state);
        m.R(i, i) = variance;
    }
    return m;
}

ErrorMeasurement level_floor_measurement(const NavigationState& state, const ImuPlace& place,
                                         const LevelFloor& floor) {
    ErrorMeasurement m(2);
    m.H.row(0) = position_rows(state, place).row(2);
    m.H(1, velocity_error + 2) = 1;
    m.innovation << floor.height_map_m - base_pose(state, place).translation_m.z(), -state.v_map_mps.z();
    m.R.diagonal() << floor.sigma_height_m * floor.sigma_height_m,
        floor.sigma_climb_mps * floor.sigma_climb_mps;
    return m;
}

ErrorMeasurement zero_velocity_measurement(const NavigationState& state, double sigma_mps) {
    ErrorMeasurement m(3);
    m.H.middleCols<3>(velocity_error).setIdentity();
    m.innovation = -state.v_map_mps;
    m.R.diagonal().setConstant(sigma_mps * sigma_mps);
    return m;
}

ErrorMeasurement base_speed_measurement(const NavigationState& state, const ImuPlace& place,
                                        const Eigen::Vector3d& omega_base_radps, int axis, double speed_mps,
                                        double sigma_mps) {
    ErrorMeasurement m(1);
    m.H = base_velocity_rows(state, place).row(axis);
    m.innovation(0) = speed_mps - base_velocity_mps(state, place, omega_base_radps)(axis);
    m.R(0, 0) = sigma_mps * sigma_mps;
    return m;
}

}  // namespace loopline::inertial
