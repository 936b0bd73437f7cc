#include "lidar_mapping/motion_state.h"

#include "inertial/rotation_vector.h"

namespace loopline::lidar_mapping {

MotionState first_state(const MotionNoise& noise) {
    MotionState state;
    Vector12d sigma;
    sigma << Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(1e-4),
        Eigen::Vector3d::Constant(noise.sigma_first_speed_mps),
        Eigen::Vector3d::Constant(noise.sigma_first_turn_radps);
    state.covariance = sigma.cwiseAbs2().asDiagonal();
    return state;
}

MotionState predict(const MotionState& state, double duration_s, const MotionNoise& noise) {
    MotionState next = state;
    next.T_map_base = state.T_map_base * exp_se3(state.velocity * duration_s);
    next.velocity_before = state.velocity;
    next.duration_s = duration_s;
    Matrix12d F = Matrix12d::Identity();
    // An error of the attitude turns the way.
    F.block<3, 3>(0, 3) =
        -inertial::cross_matrix(next.T_map_base.translation_m - state.T_map_base.translation_m);
    F.topRightCorner<6, 6>() = duration_s * Matrix6d::Identity();
    // An acceleration that is constant over the duration.
    Eigen::Matrix<double, 12, 6> G;
    G << duration_s * duration_s / 2 * Matrix6d::Identity(), duration_s * Matrix6d::Identity();
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << Eigen::Vector3d::Constant(noise.sigma_acceleration_mps2),
        Eigen::Vector3d::Constant(noise.sigma_turn_radps2);
    next.covariance =
        F * state.covariance * F.transpose() + G * sigma.cwiseAbs2().asDiagonal() * G.transpose();
    return next;
}

Pose3 pose_near(const MotionState& state, double after_s) {
    return state.T_map_base * exp_se3(SweepMotion(state).after(after_s));
}

MotionState moved_by(const MotionState& state, const Vector12d& step) {
    MotionState moved = state;
    moved.T_map_base.translation_m += step.segment<3>(0);
    moved.T_map_base.rotation =
        (inertial::exp_so3(step.segment<3>(3)) * state.T_map_base.rotation).normalized();
    const Eigen::Quaterniond to_base = state.T_map_base.rotation.conjugate();
    moved.velocity.shift_m += to_base * step.segment<3>(6);
    moved.velocity.turn_rad += to_base * step.segment<3>(9);
    return moved;
}

Vector12d difference(const MotionState& to, const MotionState& from) {
    const Eigen::Quaterniond& to_map = from.T_map_base.rotation;
    Vector12d step;
    step << to.T_map_base.translation_m - from.T_map_base.translation_m,
        inertial::log_so3(to.T_map_base.rotation * to_map.conjugate()),
        to_map * (to.velocity.shift_m - from.velocity.shift_m),
        to_map * (to.velocity.turn_rad - from.velocity.turn_rad);
    return step;
}

}  // namespace loopline::lidar_mapping
