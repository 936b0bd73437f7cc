#include "inertial/imu_check.h"

namespace loopline::inertial {

void ImuCheck::add_imu(const ImuReading& reading) {
    stamps_.add(reading.stamp_ns);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        channels_[i].add(reading.stamp_ns, reading.omega_imu_radps(axis));
        channels_[3 + i].add(reading.stamp_ns, reading.specific_force_imu_mps2(axis));
    }
    R_base_imu_ = reading.R_base_imu;
    const ImuSample sample = reading.along_base();
    force_sum_base_mps2_ += sample.specific_force_base_mps2;
    add_to_second(sample);
    agreement_.add_gyro(sample.stamp_ns, sample.omega_base_radps);
    travel_.add_imu(sample.stamp_ns, sample.specific_force_base_mps2);
}

void ImuCheck::add_to_second(const ImuSample& sample) {
    constexpr StampNs second_ns = 1'000'000'000;
    const StampNs in_ns = sample.stamp_ns - second_start_ns_;
    if (in_ns < 0 || in_ns >= second_ns) {
        const Eigen::Vector3d mean_radps =
            second_sum_radps_ / static_cast<double>(std::max<std::uint64_t>(second_readings_, 1));
        absurd_seconds_ += second_readings_ > 1 && mean_radps.norm() > absurd_rate_radps;
        second_start_ns_ = sample.stamp_ns;
        second_sum_radps_.setZero();
        second_readings_ = 0;
    }
    second_sum_radps_ += sample.omega_base_radps;
    ++second_readings_;
}

Eigen::Vector3d ImuCheck::mean_specific_force_base_mps2() const {
    return force_sum_base_mps2_ / static_cast<double>(std::max<std::uint64_t>(stamps_.count(), 1));
}

}  // namespace loopline::inertial
