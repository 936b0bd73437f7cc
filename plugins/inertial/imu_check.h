/// Whether an IMU of a log can be believed: all that `imu_verdict.h` judges by, gathered while the log
/// streams by in bounded memory.
#pragma once

#include <array>

#include "inertial/channel_statistics.h"
#include "inertial/heading_agreement.h"
#include "inertial/imu_sample.h"
#include "inertial/stamp_statistics.h"
#include "inertial/travel_agreement.h"

namespace loopline::inertial {

class ImuCheck {
 public:
    void add_imu(const ImuReading& reading);
    /// An observation that lacks one of the six channels.
    void add_incomplete() { ++incomplete_; }
    void add_odometry(StampNs stamp_ns, const Pose2& T_odom_base) {
        agreement_.add_odometry(stamp_ns, T_odom_base.phi_rad);
        travel_.add_odometry(stamp_ns, T_odom_base);
    }

    std::uint64_t incomplete() const { return incomplete_; }
    const StampStatistics& stamps() const { return stamps_; }
    /// wx wy wz ax ay az, along the sensor's axes.
    const std::array<ChannelStatistics, 6>& channels() const { return channels_; }
    /// Over the whole log: the vehicle's own accelerations cancel, gravity stays.
    Eigen::Vector3d mean_specific_force_base_mps2() const;
    const Eigen::Matrix3d& R_base_imu() const { return R_base_imu_; }
    /// Seconds in which the mean rate was beyond `absurd_rate_radps`.
    std::uint64_t absurd_seconds() const { return absurd_seconds_; }
    static constexpr double absurd_rate_radps = 6;  ///< nearly one turn a second
    Agreement agreement() const { return agreement_.result(); }
    const TravelAgreement& travel() const { return travel_; }

 private:
    void add_to_second(const ImuSample& sample);

    std::uint64_t incomplete_ = 0, absurd_seconds_ = 0;
    StampStatistics stamps_;
    std::array<ChannelStatistics, 6> channels_;
    Eigen::Vector3d force_sum_base_mps2_ = Eigen::Vector3d::Zero();
    Eigen::Matrix3d R_base_imu_ = Eigen::Matrix3d::Identity();
    StampNs second_start_ns_ = 0;
    Eigen::Vector3d second_sum_radps_ = Eigen::Vector3d::Zero();
    std::uint64_t second_readings_ = 0;
    HeadingAgreement agreement_;
    TravelAgreement travel_;
};

}  // namespace loopline::inertial
