#include "api/path_sampler.h"

#include <algorithm>
#include <tuple>

namespace loopline {

PathSampler::PathSampler(const Trajectory& trajectory, double max_gap_s)
    : trajectory_(&trajectory), max_gap_s_(max_gap_s) {
    bool first = true;
    for (const TrajectoryEntry& entry : trajectory.entries()) {
        first_ns_ = first ? entry.stamp_ns : std::min(first_ns_, entry.stamp_ns);
        last_ns_ = first ? entry.stamp_ns : std::max(last_ns_, entry.stamp_ns);
        first = false;
    }
}

std::optional<Pose3> PathSampler::at(StampNs stamp_ns, std::uint64_t hint_sequence) {
    if (stamp_ns < first_ns_ || stamp_ns > last_ns_) return std::nullopt;
    if (hint_sequence != hint_ || stamp_ns < low_ns_ || stamp_ns > high_ns_) {
        high_ns_ = low_ns_ - 1;
        const auto left = trajectory_->enclosing(stamp_ns, hint_sequence);
        if (!left) return std::nullopt;
        hint_ = hint_sequence;
        const TrajectoryEntry a = (*trajectory_)[*left],
                              b = (*trajectory_)[std::min(*left + 1, trajectory_->size() - 1)];
        std::tie(low_ns_, high_ns_) = std::minmax(a.stamp_ns, b.stamp_ns);
        const auto is_finite = [](const TrajectoryEntry& e) {
            return e.T_map_base.translation_m.allFinite() && e.T_map_base.rotation.coeffs().allFinite();
        };
        usable_ = is_finite(a) && is_finite(b) && seconds_between(low_ns_, high_ns_) <= max_gap_s_;
        if (usable_) segment_ = ScrewSegment(a.stamp_ns, a.T_map_base, b.stamp_ns, b.T_map_base);
    }
    if (!usable_) return std::nullopt;
    return segment_.at(stamp_ns);
}

}  // namespace loopline
