#include "inertial/alignment.h"

#include "inertial/rotation_vector.h"

namespace loopline::inertial {
namespace {

bool shakes(const ImuMean& mean, const AlignmentSettings& settings) {
    return mean.omega_sigma_radps.maxCoeff() > settings.still_gyro_radps ||
           mean.specific_force_sigma_mps2.maxCoeff() > settings.still_accelerometer_mps2;
}

bool turns(const ImuMean& mean, const AlignmentSettings& settings) {
    return mean.omega_base_radps.cwiseAbs().maxCoeff() > settings.largest_gyro_bias_radps;
}

bool is_long_enough(const ImuMean& mean, const AlignmentSettings& settings) {
    constexpr double rounding_of_stamps = 0.98;  // the last reading comes up to one step before the full time
    constexpr std::size_t fewest_readings = 10;
    return mean.duration_s >= rounding_of_stamps * settings.duration_s && mean.count >= fewest_readings;
}

AlignmentStatus status_of(const ImuMean& mean, const Mechanisation& mechanisation,
                          const AlignmentSettings& settings) {
    if (!is_long_enough(mean, settings)) return AlignmentStatus::too_short;
    if (shakes(mean, settings)) return AlignmentStatus::moving;
    if (turns(mean, settings)) return AlignmentStatus::turning;
    const double force_mps2 = mean.specific_force_base_mps2.norm();
    if (std::abs(force_mps2 - mechanisation.gravity_mps2) > settings.gravity_tolerance_mps2)
        return AlignmentStatus::wrong_gravity;
    return AlignmentStatus::aligned;
}

/// Rz(heading) Ry(pitch) Rx(roll) that turns the mean specific force upright.
Eigen::Quaterniond attitude(const Eigen::Vector3d& f, double heading_rad) {
    const double roll_rad = std::atan2(f.y(), f.z());
    const double pitch_rad = std::atan2(-f.x(), std::hypot(f.y(), f.z()));
    return Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX());
}

double squared(double x) {
    return x * x;
}

/// dtheta = M dba for the tilt: M = (1/g) [z]x R, whose third row is zero. See docs/papers/inertial.md.
ErrorMatrix covariance_of(const ImuMean& mean, const Eigen::Quaterniond& q_map_base,
                          const AlignmentSettings& settings) {
    const auto n = static_cast<double>(mean.count);
    ErrorVector variances;
    variances.segment<3>(position_error).setConstant(squared(settings.sigma_position_m));
    variances.segment<3>(velocity_error).setConstant(squared(settings.sigma_velocity_mps));
    variances.segment<3>(attitude_error) << 0, 0, squared(settings.sigma_heading_rad);
    variances.segment<3>(gyro_bias_error) = mean.omega_sigma_radps.cwiseAbs2() / n;
    variances.segment<3>(accelerometer_bias_error)
        .setConstant(squared(settings.sigma_accelerometer_bias_mps2));
    ErrorMatrix P = variances.asDiagonal();

    const Eigen::Matrix3d M = cross_matrix(Eigen::Vector3d::UnitZ()) * q_map_base.toRotationMatrix() /
                              mean.specific_force_base_mps2.norm();
    const Eigen::Matrix3d bias = P.block<3, 3>(accelerometer_bias_error, accelerometer_bias_error);
    const Eigen::Matrix3d noise_of_mean = (mean.specific_force_sigma_mps2.cwiseAbs2() / n).asDiagonal();
    P.block<3, 3>(attitude_error, attitude_error) += M * (bias + noise_of_mean) * M.transpose();
    P.block<3, 3>(attitude_error, accelerometer_bias_error) = M * bias;
    P.block<3, 3>(accelerometer_bias_error, attitude_error) = (M * bias).transpose();
    return P;
}

}  // namespace

bool stands_still(const ImuMean& mean, const AlignmentSettings& settings) {
    return is_long_enough(mean, settings) && !shakes(mean, settings) && !turns(mean, settings);
}

std::string words(AlignmentStatus status) {
    switch (status) {
        case AlignmentStatus::aligned:
            return "it worked";
        case AlignmentStatus::too_short:
            return "the standstill is too short; stand still for longer";
        case AlignmentStatus::moving:
            return "the vehicle moves or shakes; let it stand still at the start";
        case AlignmentStatus::turning:
            return "the vehicle turns steadily, or a gyro's bias is too large; let it stand still, or look "
                   "at the unit of the gyros";
        case AlignmentStatus::wrong_gravity:
            return "what the accelerometers read at rest is not gravity; look at their unit";
    }
    return {};
}

Alignment align(const ImuMean& mean, const Pose2& T_map_base, const Mechanisation& mechanisation,
                const AlignmentSettings& settings) {
    Alignment result;
    result.gravity_mps2 = mean.specific_force_base_mps2.norm();
    result.status = status_of(mean, mechanisation, settings);
    if (!result.aligned()) return result;
    result.state.stamp_ns = mean.latest_ns;
    result.state.q_map_base = attitude(mean.specific_force_base_mps2, T_map_base.phi_rad);
    result.state.p_map_m = {T_map_base.x_m, T_map_base.y_m, 0};
    result.state.gyro_bias_radps = mean.omega_base_radps;
    result.covariance = covariance_of(mean, result.state.q_map_base, settings);
    return result;
}

void StandstillWindow::add(const ImuSample& sample) {
    if (!samples_.empty() && sample.stamp_ns <= samples_.back().stamp_ns) samples_.clear();
    samples_.push_back(sample);
    while (seconds_between(samples_.front().stamp_ns, sample.stamp_ns) > duration_s_) samples_.pop_front();
}

ImuMean StandstillWindow::mean() const {
    ImuMean mean;
    mean.count = samples_.size();
    if (mean.count < 2) return mean;
    mean.latest_ns = samples_.back().stamp_ns;
    mean.duration_s = seconds_between(samples_.front().stamp_ns, samples_.back().stamp_ns);
    const auto n = static_cast<double>(mean.count);
    for (const auto& sample : samples_) {
        mean.omega_base_radps += sample.omega_base_radps / n;
        mean.specific_force_base_mps2 += sample.specific_force_base_mps2 / n;
    }
    for (const auto& sample :
         samples_) {  // about the mean: gravity's square would swallow the digits of noise
        mean.omega_sigma_radps += (sample.omega_base_radps - mean.omega_base_radps).cwiseAbs2() / (n - 1);
        mean.specific_force_sigma_mps2 +=
            (sample.specific_force_base_mps2 - mean.specific_force_base_mps2).cwiseAbs2() / (n - 1);
    }
    mean.omega_sigma_radps = mean.omega_sigma_radps.cwiseSqrt();
    mean.specific_force_sigma_mps2 = mean.specific_force_sigma_mps2.cwiseSqrt();
    return mean;
}

}  // namespace loopline::inertial
