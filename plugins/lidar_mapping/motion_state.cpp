#include "lidar_mapping/motion_state.h"

#include "api/dense_algebra.h"
#include "inertial/pose_error.h"
#include "inertial/rotation_vector.h"

namespace loopline::lidar_mapping {

namespace {

/// By how much an acceleration changes within half a sweep, as a part of the noise of accelerations: how it
/// is driven changes slowly, how it rolls and pitches over bumps does not.
constexpr double driven_part = 0.05, by_bumps_part = 0.15;
/// And how quickly: a bump is shorter than a sweep.
constexpr double changes_per_s = 60;
/// What is known to be as it is has a covariance that can be inverted all the same.
constexpr double least_variance = 1e-12;

}  // namespace

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
    expect_unevenness(next, noise);
    Matrix12d F = Matrix12d::Identity();
    // An error of the attitude turns the way.
    F.block<3, 3>(0, 3) =
        -inertial::cross_matrix(next.T_map_base.translation_m - state.T_map_base.translation_m);
    F.topRightCorner<6, 6>() = duration_s * Matrix6d::Identity();
    // An acceleration that is constant over the duration.
    Eigen::Matrix<double, 12, 6> G;
    G << duration_s * duration_s / 2 * Matrix6d::Identity(), duration_s * Matrix6d::Identity();
    next.covariance = propagated(F, state.covariance) +
                      propagated(G, noise.sigmas().cwiseAbs2().asDiagonal().toDenseMatrix());
    return next;
}

void expect_unevenness(MotionState& next, const MotionNoise& noise) {
    next.acceleration_off = next.jerk = {};
    next.sigma_acceleration_off = driven_part * noise.sigmas();
    next.sigma_acceleration_off.segment<2>(3).setConstant(by_bumps_part * noise.sigma_turn_radps2);
    next.sigma_jerk = changes_per_s * next.sigma_acceleration_off;
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

MotionState sweep_moved_by(const MotionState& state, const SweepVector& step) {
    MotionState moved = moved_by(state, Vector12d(step.head<12>()));
    const Eigen::Quaterniond to_base = state.T_map_base.rotation.conjugate();
    moved.acceleration_off.shift_m += to_base * step.segment<3>(12);
    moved.acceleration_off.turn_rad += to_base * step.segment<3>(15);
    moved.jerk.shift_m += to_base * step.segment<3>(18);
    moved.jerk.turn_rad += to_base * step.segment<3>(21);
    return moved;
}

SweepVector sweep_difference(const MotionState& to, const MotionState& from) {
    const Eigen::Quaterniond& to_map = from.T_map_base.rotation;
    const Twist3 acceleration = to.acceleration_off - from.acceleration_off, jerk = to.jerk - from.jerk;
    SweepVector step;
    step << difference(to, from), to_map * acceleration.shift_m, to_map * acceleration.turn_rad,
        to_map * jerk.shift_m, to_map * jerk.turn_rad;
    return step;
}

SweepMatrix sweep_covariance(const MotionState& predicted) {
    const Matrix6d R = inertial::turned_both(predicted.T_map_base.rotation);
    const auto along_map = [&](const Vector6d& sigma) {
        return propagated(R, sigma.cwiseAbs2().cwiseMax(least_variance).asDiagonal().toDenseMatrix());
    };
    SweepMatrix covariance = SweepMatrix::Zero();
    covariance.topLeftCorner<12, 12>() = predicted.covariance;
    covariance.block<6, 6>(12, 12) = along_map(predicted.sigma_acceleration_off);
    covariance.block<6, 6>(18, 18) = along_map(predicted.sigma_jerk);
    return covariance;
}

}  // namespace loopline::lidar_mapping
