#include "inertial/error_state.h"

#include "api/dense_algebra.h"
#include "inertial/rotation_vector.h"

namespace loopline::inertial {
namespace {

/// Derivatives of one step, in the map frame. See docs/papers/inertial.md.
struct StepDerivatives {
    double dt;
    Eigen::Matrix3d A;  ///< [a]x, a = R(mid) f
    Eigen::Matrix3d B;  ///< R Jl(turn) dt: attitude at the end by gyro bias, with a minus
    Eigen::Matrix3d C;  ///< R Jl(turn/2) dt/2: the same in the middle
    Eigen::Matrix3d R_map_mid;
};

StepDerivatives derivatives(const NavigationState& state, const ImuSample& from, const ImuSample& to) {
    const ImuStep step = step_between(state, from, to);
    const double dt = step.duration_s;
    const Eigen::Matrix3d R_map_base = state.q_map_base.toRotationMatrix();
    StepDerivatives d;
    d.dt = dt;
    d.R_map_mid = (state.q_map_base * exp_so3(step.turn_rad / 2)).toRotationMatrix();
    d.A = cross_matrix(d.R_map_mid * step.specific_force_base_mps2);
    d.B = R_map_base * left_jacobian(step.turn_rad) * dt;
    d.C = R_map_base * left_jacobian(step.turn_rad / 2) * (dt / 2);
    return d;
}

/// The rows of the velocity on those of attitude and biases at the start of the step.
template <class Rows>
void set_velocity_rows(Rows rows, const StepDerivatives& d, double sign) {
    rows.template middleCols<3>(attitude_error) = -sign * d.dt * d.A;
    rows.template middleCols<3>(gyro_bias_error) = sign * d.dt * d.A * d.C;
    rows.template middleCols<3>(accelerometer_bias_error) = -sign * d.dt * d.R_map_mid;
}

}  // namespace

ErrorMatrix transition(const NavigationState& state_from, const ImuSample& from, const ImuSample& to) {
    const StepDerivatives d = derivatives(state_from, from, to);
    ErrorMatrix Phi = ErrorMatrix::Identity();
    Phi.block<3, 3>(attitude_error, gyro_bias_error) = -d.B;
    set_velocity_rows(Phi.middleRows<3>(velocity_error), d, 1);
    // p += dt/2 (v before + v after)
    Phi.middleRows<3>(position_error) += d.dt / 2 * Phi.middleRows<3>(velocity_error);
    Phi.block<3, 3>(position_error, velocity_error) += d.dt / 2 * Eigen::Matrix3d::Identity();
    return Phi;
}

ErrorMatrix inverse_transition(const NavigationState& state_from, const ImuSample& from,
                               const ImuSample& to) {
    const StepDerivatives d = derivatives(state_from, from, to);
    ErrorMatrix Phi = ErrorMatrix::Identity();
    Phi.block<3, 3>(attitude_error, gyro_bias_error) = d.B;
    set_velocity_rows(Phi.middleRows<3>(velocity_error), d, -1);
    // The attitude at the start is that at the end and what the bias added in between.
    Phi.block<3, 3>(velocity_error, gyro_bias_error) += Phi.block<3, 3>(velocity_error, attitude_error) * d.B;
    Phi.middleRows<3>(position_error) -= d.dt / 2 * Phi.middleRows<3>(velocity_error);
    Phi.block<3, 3>(position_error, velocity_error) -= d.dt / 2 * Eigen::Matrix3d::Identity();
    return Phi;
}

ErrorMatrix process_noise(const ImuNoise& noise, const ErrorMatrix& Phi, double duration_s) {
    const auto square = [](double x) { return x * x; };
    ErrorVector density = ErrorVector::Zero();  // of each error's own white noise, the same along all axes
    density.segment<3>(velocity_error).setConstant(square(noise.accelerometer.density_mps2_sqrt_hz));
    density.segment<3>(attitude_error).setConstant(square(noise.gyro.density_radps_sqrt_hz));
    density.segment<3>(gyro_bias_error).setConstant(square(noise.gyro.bias_walk_radps_sqrt_s));
    density.segment<3>(accelerometer_bias_error)
        .setConstant(square(noise.accelerometer.bias_walk_mps2_sqrt_s));
    // Integral of Phi(t, end) S Phi(t, end)' over the step, by the trapezoid rule: noise at its start passes
    // through Phi, noise at its end does not.
    ErrorMatrix Q = propagated(Phi, density.asDiagonal().toDenseMatrix());
    Q.diagonal() += density;
    return std::abs(duration_s) / 2 * Q;
}

NavigationState inject(const NavigationState& state, const ErrorVector& error) {
    NavigationState corrected = state;
    corrected.p_map_m += error.segment<3>(position_error);
    corrected.v_map_mps += error.segment<3>(velocity_error);
    corrected.q_map_base = (exp_so3(error.segment<3>(attitude_error)) * state.q_map_base).normalized();
    corrected.gyro_bias_radps += error.segment<3>(gyro_bias_error);
    corrected.accelerometer_bias_mps2 += error.segment<3>(accelerometer_bias_error);
    return corrected;
}

ErrorVector error_between(const NavigationState& state, const NavigationState& truth) {
    ErrorVector error;
    error << truth.p_map_m - state.p_map_m, truth.v_map_mps - state.v_map_mps,
        log_so3(truth.q_map_base * state.q_map_base.conjugate()),
        truth.gyro_bias_radps - state.gyro_bias_radps,
        truth.accelerometer_bias_mps2 - state.accelerometer_bias_mps2;
    return error;
}

ErrorMatrix covariance_after_injection(const ErrorMatrix& covariance, const ErrorVector& error) {
    // Exp(a + d) Exp(-a) = Exp(Jl(a) d)
    ErrorMatrix G = ErrorMatrix::Identity();
    G.block<3, 3>(attitude_error, attitude_error) = left_jacobian(error.segment<3>(attitude_error));
    return propagated(G, covariance);
}

}  // namespace loopline::inertial
