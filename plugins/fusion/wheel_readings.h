/// Wheel odometry as it comes: readings in order, without those that can't be.
#pragma once

#include <cstdint>
#include <optional>

#include "api/pose2.h"
#include "api/stamp.h"
#include "api/twist2.h"

namespace loopline::fusion {

class WheelReadings {
 public:
    enum class Verdict {
        good,
        not_finite,
        backward,    ///< not later than the one before
        implausible  ///< faster than any vehicle, as where the odometry's pose is set anew
    };
    /// Counts the next one. Of an implausible one the way since the one before counts as the same again as
    /// before, and what comes after it goes on from there.
    Verdict take(StampNs stamp_ns, const Pose2& T_told_base);

    /// By the latest good or implausible one: the motion since the one before, and the pose.
    const Twist2& motion() const { return motion_; }
    const Pose2& T_odom_base() const { return T_odom_base_; }

    std::int64_t count(Verdict verdict) const { return count_[static_cast<int>(verdict)]; }
    std::int64_t taken() const { return count(Verdict::good) + count(Verdict::implausible); }

 private:
    template <class Archive>
    friend void fields(Archive& archive, WheelReadings& readings) {
        archive(readings.stamp_ns_, readings.T_odom_told_, readings.T_odom_base_, readings.motion_,
                readings.over_s_);
        for (auto& count : readings.count_) archive(count);
    }
    Verdict judge(StampNs stamp_ns, const Pose2& T_told_base) const;

    std::optional<StampNs> stamp_ns_;  ///< of the latest
    Pose2 T_odom_told_;                ///< moves where what is told jumps
    Pose2 T_odom_base_;
    Twist2 motion_;
    double over_s_ = 0;  ///< of that
    std::int64_t count_[4] = {};
};

}  // namespace loopline::fusion
