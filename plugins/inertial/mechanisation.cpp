#include "inertial/mechanisation.h"

#include "inertial/rotation_vector.h"

namespace loopline::inertial {
namespace {

/// q * Exp(turn_rad), as q + q (Exp - 1): a tilt error e pulls the position off by g e t^2 / 2, so in ten
/// minutes the last digits of the attitude are what parts forward from reverse, and a small increment rounds
/// them least.
void turn(Eigen::Quaterniond& q, const Eigen::Vector3d& turn_rad) {
    Eigen::Quaterniond increment = exp_so3(turn_rad);
    increment.w() = -increment.vec().squaredNorm() / (1 + increment.w());  // cos - 1, without cancellation
    Eigen::Vector4d step = (q * increment).coeffs();
    step -= 0.5 * (q.squaredNorm() - 1) * q.coeffs();  // keeps the length at 1
    q.coeffs() += step;
}

/// R(mid-interval) f + g, in the map frame.
Eigen::Vector3d acceleration_map_mps2(const Eigen::Quaterniond& q_map_base_at_start, const ImuStep& step,
                                      double gravity_mps2) {
    const Eigen::Quaterniond q_map_mid = q_map_base_at_start * exp_so3(step.turn_rad / 2);
    return q_map_mid * step.specific_force_base_mps2 - gravity_mps2 * Eigen::Vector3d::UnitZ();
}

}  // namespace

ImuStep step_between(const NavigationState& biases, const ImuSample& from, const ImuSample& to) {
    const double duration_s = seconds_between(from.stamp_ns, to.stamp_ns);
    return {
        duration_s, ((from.omega_base_radps + to.omega_base_radps) / 2 - biases.gyro_bias_radps) * duration_s,
        (from.specific_force_base_mps2 + to.specific_force_base_mps2) / 2 - biases.accelerometer_bias_mps2};
}

NavigationState Mechanisation::forward(const NavigationState& state, const ImuSample& from,
                                       const ImuSample& to) const {
    const ImuStep step = step_between(state, from, to);
    const double dt = step.duration_s;
    NavigationState next = state;
    next.stamp_ns = to.stamp_ns;
    next.v_map_mps += dt * acceleration_map_mps2(state.q_map_base, step, gravity_mps2);
    next.p_map_m += dt / 2 * (state.v_map_mps + next.v_map_mps);
    turn(next.q_map_base, step.turn_rad);
    return next;
}

NavigationState Mechanisation::reverse(const NavigationState& state, const ImuSample& from,
                                       const ImuSample& to) const {
    const ImuStep step = step_between(state, from, to);
    const double dt = step.duration_s;
    NavigationState previous = state;
    previous.stamp_ns = from.stamp_ns;
    turn(previous.q_map_base, -step.turn_rad);
    previous.v_map_mps -= dt * acceleration_map_mps2(previous.q_map_base, step, gravity_mps2);
    previous.p_map_m -= dt / 2 * (previous.v_map_mps + state.v_map_mps);
    return previous;
}

}  // namespace loopline::inertial
