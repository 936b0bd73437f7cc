#include "evaluate/association.h"

#include <algorithm>
#include <cmath>

namespace loopline {

std::vector<PosePair> associate_by_stamp(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference, double max_difference_s) {
    const auto earlier = [](const StampedPose& a, const StampedPose& b) { return a.stamp_ns < b.stamp_ns; };
    std::vector<StampedPose> sorted_copy;
    if (!std::is_sorted(reference.begin(), reference.end(), earlier)) {
        sorted_copy = reference;
        std::stable_sort(sorted_copy.begin(), sorted_copy.end(), earlier);
    }
    const std::vector<StampedPose>& sorted = sorted_copy.empty() ? reference : sorted_copy;

    std::vector<PosePair> pairs;
    pairs.reserve(estimate.size());
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        const StampNs stamp_ns = estimate[i].stamp_ns;
        const auto difference_s = [stamp_ns](const StampedPose& p) {
            return std::abs(seconds_between(p.stamp_ns, stamp_ns));
        };
        auto nearest = std::lower_bound(sorted.begin(), sorted.end(), stamp_ns,
                                        [](const auto& p, StampNs stamp) { return p.stamp_ns < stamp; });
        if (nearest == sorted.end() ||
            (nearest != sorted.begin() && difference_s(*std::prev(nearest)) <= difference_s(*nearest))) {
            if (nearest == sorted.begin()) break;  // no reference at all
            --nearest;
        }
        if (difference_s(*nearest) <= max_difference_s)
            pairs.push_back({stamp_ns, i, estimate[i].T_map_base, nearest->T_map_base});
    }
    return pairs;
}

std::vector<PosePair> associate_by_index(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference) {
    std::vector<PosePair> pairs;
    for (std::size_t i = 0; i < std::min(estimate.size(), reference.size()); ++i)
        pairs.push_back({estimate[i].stamp_ns, i, estimate[i].T_map_base, reference[i].T_map_base});
    return pairs;
}

}  // namespace loopline
