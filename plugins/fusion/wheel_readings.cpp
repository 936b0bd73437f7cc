#include "fusion/wheel_readings.h"

#include <algorithm>
#include <cmath>

namespace loopline::fusion {
namespace {

constexpr double fastest_mps = 100, fastest_turn_radps = 15;
/// Stamps on reception come in bunches: within less time than this nothing tells a speed.
constexpr double least_s = 0.05;

}  // namespace

WheelReadings::Verdict WheelReadings::judge(StampNs stamp_ns, const Pose2& T_told_base) const {
    if (!std::isfinite(T_told_base.x_m) || !std::isfinite(T_told_base.y_m) ||
        !std::isfinite(T_told_base.phi_rad))
        return Verdict::not_finite;
    if (!stamp_ns_) return Verdict::good;
    if (stamp_ns <= *stamp_ns_) return Verdict::backward;
    const double over_s = std::max(least_s, seconds_between(*stamp_ns_, stamp_ns));
    const Twist2 told = log_se2(T_odom_base_.inverse() * (T_odom_told_ * T_told_base));
    const bool possible = std::hypot(told.forward_m, told.left_m) < fastest_mps * over_s &&
                          std::abs(told.turn_rad) < fastest_turn_radps * over_s;
    return possible ? Verdict::good : Verdict::implausible;
}

WheelReadings::Verdict WheelReadings::take(StampNs stamp_ns, const Pose2& T_told_base) {
    const Verdict verdict = judge(stamp_ns, T_told_base);
    ++count_[static_cast<int>(verdict)];
    if (verdict == Verdict::not_finite || verdict == Verdict::backward) return verdict;
    const double over_s = stamp_ns_ ? seconds_between(*stamp_ns_, stamp_ns) : 0;
    if (verdict == Verdict::implausible) {
        const double as_long = over_s_ > 0 ? over_s / over_s_ : 0;
        motion_ = {as_long * motion_.forward_m, as_long * motion_.left_m, as_long * motion_.turn_rad};
        T_odom_base_ = T_odom_base_ * exp_se2(motion_);
        T_odom_told_ = T_odom_base_ * T_told_base.inverse();
    } else {
        const Pose2 T_odom_base = T_odom_told_ * T_told_base;
        motion_ = stamp_ns_ ? log_se2(T_odom_base_.inverse() * T_odom_base) : Twist2{};
        T_odom_base_ = T_odom_base;
    }
    stamp_ns_ = stamp_ns;
    over_s_ = over_s;
    return verdict;
}

}  // namespace loopline::fusion
