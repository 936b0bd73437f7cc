#include "evaluate/kitti_segments.h"

#include <algorithm>
#include <cmath>

#include "evaluate/relative_error.h"

namespace loopline {

KittiError kitti_error(const std::vector<PosePair>& pairs) {
    constexpr std::size_t poses_between_segments = 10;
    KittiError error;
    const std::vector<double> way_m = reference_way_m(pairs);
    for (std::size_t first = 0; first < pairs.size(); first += poses_between_segments)
        for (int hundreds = 1; hundreds <= 8; ++hundreds) {
            const double length_m = 100.0 * hundreds;
            const auto end = std::upper_bound(way_m.begin() + static_cast<std::ptrdiff_t>(first), way_m.end(),
                                              way_m[first] + length_m);
            if (end == way_m.end()) break;
            const auto last = static_cast<std::size_t>(end - way_m.begin());
            const Pose3 motion_reference =
                pairs[first].T_ref_base_reference.inverse() * pairs[last].T_ref_base_reference;
            const Pose3 motion_estimate =
                pairs[first].T_map_base_estimate.inverse() * pairs[last].T_map_base_estimate;
            const Pose3 difference = motion_estimate.inverse() * motion_reference;
            error.segments.push_back({first, last, length_m, difference.translation_m.norm(),
                                      rotation_angle_rad(difference.rotation)});
        }
    for (const auto& segment : error.segments) {
        const double share = 1 / (segment.length_m * static_cast<double>(error.segments.size()));
        error.translation_percent += 100 * segment.translation_m * share;
        error.rotation_deg_per_m += segment.rotation_rad * 180 / M_PI * share;
    }
    return error;
}

}  // namespace loopline
