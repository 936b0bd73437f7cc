#include "output/stamped_path.h"

#include <algorithm>

namespace loopline {

const StampedPath& in_order_of_stamps(const StampedPath& path, StampedPath& sorted) {
    bool in_order = true;
    for (std::size_t i = 1; i < path.size(); ++i)
        in_order = in_order && path.stamp_ns(i - 1) <= path.stamp_ns(i);
    if (in_order) return path;
    std::vector<StampedPose> poses(path.begin(), path.end());
    std::stable_sort(poses.begin(), poses.end(),
                     [](const auto& a, const auto& b) { return a.stamp_ns < b.stamp_ns; });
    sorted = StampedPath(poses);
    return sorted;
}

}  // namespace loopline
