/// Navigation by an IMU, with or without wheels: strapdown mechanisation whose errors a Kalman filter
/// estimates from what the scans say (rows B3 and B4). Until the vehicle has stood still for a moment, only
/// scans tell where it goes.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "grid_slam/forward_match.h"
#include "grid_slam/navigation.h"
#include "grid_slam/reverse_pass.h"
#include "inertial/alignment.h"
#include "inertial/error_state_filter.h"
#include "inertial/planar_updates.h"

namespace loopline::grid_slam {

struct InertialSettings {
    inertial::ImuNoise noise;
    inertial::AlignmentSettings alignment;
    double gravity_mps2 = 9.80665;
    double coarse_after_s = 8;  ///< without a standstill for so long, what there is must do
    MapNoise map;
    /// What a step is wrong by beside what the filter states: its speed comes from scans of the same map, so
    /// it is not new beside them, and a gyro's scale is not one of the errors that are estimated.
    double sigma_speed_mps = 0.05;
    double sigma_turn = 0.003;     ///< as a part of the turn
    double corner_rad = M_PI / 2;  ///< turn within which a wrong scale keeps its sign, about
    /// How long what the filter has wrong of speed and gyro bias stays so, about.
    double speed_lasts_s = 5, bias_lasts_s = 30;
    inertial::LevelFloor floor;
    bool wheels = false;         ///< use their speed too
    bool keep_readings = false;  ///< for those who go back
    double sigma_wheel_mps = 0.05;
    double sigma_side_mps = 0.05;
    /// While nothing but scans tells the motion: how much it changes from scan to scan.
    double sigma_steady_m = 0.03, sigma_steady_rad = 2 * M_PI / 180;
};

class InertialNavigation {
 public:
    explicit InertialNavigation(const InertialSettings& settings);

    /// In the order of their stamps; one that goes backwards is left out.
    void add(const inertial::ImuSample& sample, const Eigen::Vector3d& p_base_imu_m);
    /// Whether the readings reach beyond a time.
    bool reaches(StampNs stamp_ns) const { return !samples_.empty() && samples_.back().stamp_ns >= stamp_ns; }

    /// At the scan; `T_odom_base`: dead reckoning there, if there are wheels.
    Prediction predict(StampNs stamp_ns, const std::optional<Pose2>& T_odom_base);
    void update(const ForwardMatch& match);
    void move(const Pose2& T_new_old);

    bool aligned() const { return aligned_; }
    const inertial::ErrorStateFilter& filter() const { return filter_; }
    inertial::AlignmentStatus alignment_status() const { return alignment_status_; }
    std::int64_t refused() const { return refused_; }
    std::int64_t backward() const { return backward_; }

 private:
    template <class Archive>
    friend void fields(Archive&, InertialNavigation&);
    friend class InertialReverse;
    void propagate(StampNs stamp_ns);
    void try_to_align();
    void take_wheels(const std::optional<Pose2>& T_odom_base, double duration_s);
    Prediction steady(StampNs stamp_ns, const std::optional<Pose2>& T_odom_base) const;

    InertialSettings settings_;
    inertial::Mechanisation mechanisation_;
    inertial::ErrorStateFilter filter_;
    inertial::ImuPlace place_;
    inertial::StandstillWindow window_;
    inertial::AlignmentStatus alignment_status_ = inertial::AlignmentStatus::too_short;
    bool aligned_ = false;
    std::deque<inertial::ImuSample> samples_;    ///< not used up yet
    std::vector<inertial::ImuSample> readings_;  ///< all, if they are kept
    std::optional<inertial::ImuSample> latest_;  ///< that the filter has come to
    std::optional<StampNs> first_ns_, scan_ns_;  ///< first reading, latest scan
    std::optional<Pose2> T_odom_base_;           ///< at the latest scan
    Pose2 T_map_base_, T_before_now_;            ///< at the latest scan, and since the one before
    Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
    double step_s_ = 0;  ///< from the scan before to the latest one
    std::int64_t refused_ = 0, backward_ = 0;
};

/// Inertial navigation backwards in time, from what the forward one knows now, over the readings that it
/// kept.
class InertialReverse : public ReverseNavigation {
 public:
    /// Both outlive it.
    InertialReverse(const InertialNavigation& navigation, const MapFrames& map);
    void start(std::uint32_t frame, const Pose2& T_map_base, const Eigen::Matrix3d& covariance) override;
    Motion motion_back(std::uint32_t to) override;
    void update(const ForwardMatch& match) override;

 private:
    inertial::ImuSample reading_at(StampNs stamp_ns) const;

    const InertialNavigation& navigation_;
    const MapFrames& map_;
    inertial::ErrorStateFilter filter_;
    std::uint32_t frame_ = 0;
    double step_s_ = 0;           ///< of the latest step back
    std::size_t next_ = 0;        ///< reading after the time that the filter is at
    inertial::ImuSample latest_;  ///< at that time
};

}  // namespace loopline::grid_slam
