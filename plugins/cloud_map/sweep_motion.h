/// Where the lidar was at each moment of a sweep, quickly enough for every one of its points.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "api/pose3.h"
#include "api/stamp.h"
#include "lidar/spinning_scan.h"

namespace loopline::cloud_map {

using PoseAt = std::function<std::optional<Pose3>(StampNs stamp_ns)>;

/// T_map_lidar at moments `step` apart, and between them along the chord: a turn of 1 rad/s for 3 ms leaves
/// it by 1e-6 rad, an acceleration of 10 m/s2 by 12 um.
class SweepMotion {
 public:
    /// False where `T_map_base` has no pose for a moment of the sweep.
    bool follow(const lidar::SpinningScan& scan, const PoseAt& T_map_base);

    /// Of the lidar in the middle of the sweep; what is relative to it can be told in single precision.
    const Eigen::Vector3d& middle_m() const { return middle_m_; }
    /// A point that was seen `time_s` after the scan's stamp, in the map.
    Eigen::Vector3d p_map_m(const lidar::SpinningPoint& point) const {
        const Leg& leg = leg_at(point.time_s);
        const float u = point.time_s - leg.begin_s;
        const Eigen::Vector3f p(point.x_m, point.y_m, point.z_m);
        const Eigen::Vector3f from_middle_m = leg.R * p + leg.t_m + u * (leg.R_per_s * p + leg.t_mps);
        return middle_m_ + from_middle_m.cast<double>();
    }
    /// Rotation and position (from middle_m()) at a time.
    void at(float time_s, Eigen::Matrix3f& R_map_lidar, Eigen::Vector3f& from_middle_m) const {
        const Leg& leg = leg_at(time_s);
        const float u = time_s - leg.begin_s;
        R_map_lidar = leg.R + u * leg.R_per_s;
        from_middle_m = leg.t_m + u * leg.t_mps;
    }

 private:
    struct Leg {
        float begin_s;
        Eigen::Matrix3f R, R_per_s;
        Eigen::Vector3f t_m, t_mps;
    };
    const Leg& leg_at(float time_s) const {
        const float k = (time_s - begin_s_) * per_leg_s_;
        const auto last = static_cast<float>(legs_.size() - 1);
        return legs_[static_cast<std::size_t>(k < 0 ? 0 : k > last ? last : k)];
    }

    float begin_s_ = 0, per_leg_s_ = 0;
    Eigen::Vector3d middle_m_ = Eigen::Vector3d::Zero();
    std::vector<Leg> legs_;
};

}  // namespace loopline::cloud_map
