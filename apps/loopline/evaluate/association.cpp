#include "evaluate/association.h"

#include <algorithm>
#include <cmath>

namespace loopline {

std::vector<StampedPose> way_of_point(std::vector<StampedPose> poses, const Eigen::Vector2d& point_m) {
    const Pose3 T_base_point(Pose2{point_m.x(), point_m.y(), 0});
    if (!point_m.isZero())
        for (StampedPose& pose : poses) pose.T_map_base = pose.T_map_base * T_base_point;
    return poses;
}

namespace {

constexpr double max_bridge = 10;  // of interpolation, over the greatest difference in time

/// The poses by stamp: themselves, or a copy that is put into `sorted`.
const std::vector<StampedPose>& in_order(const std::vector<StampedPose>& poses, std::vector<StampedPose>& sorted) {
    const auto earlier = [](const StampedPose& a, const StampedPose& b) { return a.stamp_ns < b.stamp_ns; };
    if (std::is_sorted(poses.begin(), poses.end(), earlier)) return poses;
    sorted = poses;
    std::stable_sort(sorted.begin(), sorted.end(), earlier);
    return sorted;
}

/// The position at `stamp_ns`, which lies between a and b, as far as neither is too far away; else that of
/// the nearest.
Pose3 position_between(const StampedPose& a, const StampedPose& b, StampNs stamp_ns, double max_bridge_s) {
    const double before_s = seconds_between(a.stamp_ns, stamp_ns), after_s = seconds_between(stamp_ns, b.stamp_ns);
    if (before_s > max_bridge_s || after_s > max_bridge_s || before_s + after_s <= 0)
        return before_s <= after_s ? a.T_map_base : b.T_map_base;
    Pose3 pose = a.T_map_base;
    pose.translation_m += before_s / (before_s + after_s) * (b.T_map_base.translation_m - a.T_map_base.translation_m);
    return pose;
}

template <class Reference>
std::vector<PosePair> associate(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& reference,
                                double max_difference_s, const Reference& reference_at) {
    std::vector<StampedPose> copy;
    const std::vector<StampedPose>& sorted = in_order(reference, copy);
    std::vector<PosePair> pairs;
    if (sorted.empty()) return pairs;
    pairs.reserve(estimate.size());
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        const StampNs stamp_ns = estimate[i].stamp_ns;
        const auto difference_s = [stamp_ns](const StampedPose& p) {
            return std::abs(seconds_between(p.stamp_ns, stamp_ns));
        };
        const auto after = std::lower_bound(sorted.begin(), sorted.end(), stamp_ns,
                                            [](const auto& p, StampNs stamp) { return p.stamp_ns < stamp; });
        const StampedPose& next = after == sorted.end() ? sorted.back() : *after;
        const StampedPose& previous = after == sorted.begin() ? next : *std::prev(after);
        const StampedPose& nearest = difference_s(previous) <= difference_s(next) ? previous : next;
        if (difference_s(nearest) <= max_difference_s)
            pairs.push_back({stamp_ns, i, estimate[i].T_map_base, reference_at(previous, next, nearest, stamp_ns)});
    }
    return pairs;
}

}  // namespace

std::vector<PosePair> associate_by_stamp(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference, double max_difference_s) {
    return associate(estimate, reference, max_difference_s,
                     [](const auto&, const auto&, const StampedPose& nearest, StampNs) { return nearest.T_map_base; });
}

std::vector<PosePair> associate_positions(const std::vector<StampedPose>& estimate,
                                          const std::vector<StampedPose>& reference, double max_difference_s) {
    return associate(estimate, reference, max_difference_s,
                     [&](const StampedPose& previous, const StampedPose& next, const auto&, StampNs stamp_ns) {
                         return position_between(previous, next, stamp_ns, max_bridge * max_difference_s);
                     });
}

std::vector<PosePair> associate_by_index(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference) {
    std::vector<PosePair> pairs;
    for (std::size_t i = 0; i < std::min(estimate.size(), reference.size()); ++i)
        pairs.push_back({estimate[i].stamp_ns, i, estimate[i].T_map_base, reference[i].T_map_base});
    return pairs;
}

}  // namespace loopline
