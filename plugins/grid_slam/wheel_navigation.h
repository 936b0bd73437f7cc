/// Navigation by wheel odometry alone.
#pragma once

#include <optional>

#include "api/stamp.h"
#include "grid_slam/forward_match.h"
#include "grid_slam/navigation.h"
#include "grid_slam/reverse_pass.h"

namespace loopline::grid_slam {

class WheelNavigation {
 public:
    explicit WheelNavigation(const WheelNoise& noise) : noise_(noise) {}

    /// `T_odom_base`: dead reckoning at the scan; none: the vehicle is taken to stand.
    Prediction predict(StampNs stamp_ns, const std::optional<Pose2>& T_odom_base) const {
        Prediction p;
        p.stamp_ns = stamp_ns;
        p.duration_s = started_ ? seconds_between(stamp_ns_, stamp_ns) : 0;
        if (started_)
            p.motion =
                wheel_motion(T_odom_base && T_odom_base_ ? T_odom_base_->inverse() * *T_odom_base : Pose2{},
                             p.duration_s, noise_);
        const Motion now = Motion{T_map_base_, covariance_} * p.motion;
        p.T_map_base = now.T_before_now;
        p.covariance = now.covariance;
        return p;
    }

    /// What came of the scan.
    void update(StampNs stamp_ns, const std::optional<Pose2>& T_odom_base, const ForwardMatch& match) {
        started_ = true;
        stamp_ns_ = stamp_ns;
        if (T_odom_base) T_odom_base_ = T_odom_base;
        T_map_base_ = match.T_map_base;
        covariance_ = match.begins_map ? Eigen::Matrix3d::Zero().eval() : match.covariance;
    }
    /// The map was corrected, and the vehicle moved with it.
    void move(const Pose2& T_new_old) {
        T_map_base_ = T_new_old * T_map_base_;
        covariance_ = turned(covariance_, T_new_old.phi_rad);
    }

 private:
    template <class Archive>
    friend void fields(Archive&, WheelNavigation&);
    WheelNoise noise_;
    bool started_ = false;
    StampNs stamp_ns_ = 0;
    std::optional<Pose2> T_odom_base_;
    Pose2 T_map_base_;
    Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
};

/// The way forward, turned round.
class WheelReverse : public ReverseNavigation {
 public:
    /// `map` outlives it.
    explicit WheelReverse(const MapFrames& map) : map_(map) {}
    void start(std::uint32_t, const Pose2&, const Eigen::Matrix3d&) override {}
    Motion motion_back(std::uint32_t to) override { return inverse(map_.motions[to + 1]); }
    void update(const ForwardMatch&) override {}

 private:
    const MapFrames& map_;
};

}  // namespace loopline::grid_slam
