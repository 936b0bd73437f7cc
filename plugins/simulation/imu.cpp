#include "simulation/imu.h"

#include <cmath>

namespace loopline::simulation {
namespace {

Eigen::Vector3d mean_velocity_mps(const SensorPoseAt& T_map_sensor, StampNs time_ns, StampNs window_ns) {
    const Eigen::Vector3d way_m =
        T_map_sensor(time_ns + window_ns).translation_m - T_map_sensor(time_ns - window_ns).translation_m;
    return way_m / (2e-9 * static_cast<double>(window_ns));
}

Eigen::Vector3d rotation_vector_rad(Eigen::Quaterniond q) {
    if (q.w() < 0) q.coeffs() *= -1;
    const double sine = q.vec().norm();
    if (sine < 1e-12) return 2 * q.vec();
    return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

}  // namespace

InertialRates true_rates(const SensorPoseAt& T_map_sensor, StampNs from_ns, StampNs to_ns,
                         StampNs window_ns) {
    const double duration_s = seconds_between(from_ns, to_ns);
    const Eigen::Quaterniond q_map_from = T_map_sensor(from_ns).rotation,
                             q_map_to = T_map_sensor(to_ns).rotation;
    const Eigen::Vector3d change_mps = mean_velocity_mps(T_map_sensor, to_ns, window_ns) -
                                       mean_velocity_mps(T_map_sensor, from_ns, window_ns);
    // The velocity increment in the axes of the middle of the interval: right to second order in its length.
    const Eigen::Quaterniond q_map_middle = q_map_from.slerp(0.5, q_map_to);
    return {rotation_vector_rad(q_map_from.conjugate() * q_map_to) / duration_s,
            q_map_middle.conjugate() * (change_mps / duration_s + gravity_mps2 * Eigen::Vector3d::UnitZ())};
}

Triad::Triad(const TriadSettings& settings, double rate_hz, RandomStream random)
    : settings_(settings),
      keep_(std::exp(-1 / (rate_hz * settings.drift_s))),
      sigma_sample_(settings.noise * std::sqrt(rate_hz)),
      random_(random),
      turn_on_bias_(drawn(settings.bias)),
      scale_error_(drawn(settings.scale_error)),
      drift_(Eigen::Vector3d::Zero()) {}

Eigen::Vector3d Triad::drawn(double sigma) {
    const double x = random_.normal(sigma), y = random_.normal(sigma), z = random_.normal(sigma);
    return {x, y, z};
}

Eigen::Vector3d Triad::measured(const Eigen::Vector3d& truth) {
    drift_ = keep_ * drift_ + drawn(settings_.drift * std::sqrt(1 - keep_ * keep_));
    Eigen::Vector3d reading =
        truth + scale_error_.cwiseProduct(truth) + turn_on_bias_ + drift_ + drawn(sigma_sample_);
    if (settings_.resolution > 0)
        reading = (reading / settings_.resolution).array().round().matrix() * settings_.resolution;
    return reading;
}

}  // namespace loopline::simulation
