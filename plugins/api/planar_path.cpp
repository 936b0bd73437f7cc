#include "api/planar_path.h"

#include <algorithm>

namespace loopline {

bool PlanarPath::take(StampNs stamp_ns, const Pose2& T_odom_base) {
    if (!samples_.empty() && stamp_ns <= samples_.back().stamp_ns) return false;
    samples_.push_back({stamp_ns, T_odom_base});
    return true;
}

std::optional<Pose2> PlanarPath::at(StampNs stamp_ns) const {
    const auto after = std::lower_bound(samples_.begin(), samples_.end(), stamp_ns,
                                        [](const Sample& s, StampNs t) { return s.stamp_ns < t; });
    if (after == samples_.end()) return std::nullopt;
    if (after->stamp_ns == stamp_ns) return after->T_odom_base;
    if (after == samples_.begin()) return std::nullopt;
    const Sample& before = *(after - 1);
    return interpolate_se2(
        before.T_odom_base, after->T_odom_base,
        seconds_between(before.stamp_ns, stamp_ns) / seconds_between(before.stamp_ns, after->stamp_ns));
}

std::optional<Twist2> PlanarPath::motion(StampNs from_ns, StampNs to_ns) const {
    const auto from = at(from_ns), to = at(to_ns);
    if (!from || !to) return std::nullopt;
    return log_se2(from->inverse() * *to);
}

void PlanarPath::forget_before(StampNs stamp_ns) {
    while (samples_.size() > 1 && samples_[1].stamp_ns <= stamp_ns) samples_.pop_front();
}

}  // namespace loopline
