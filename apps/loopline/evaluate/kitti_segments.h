/// KITTI's odometry metric: errors over segments of 100 to 800 m, as its development kit computes them.
/// Geiger, Lenz, Urtasun 2012, "Are we ready for autonomous driving?"; the kit's evaluate_odometry.cpp.
#pragma once

#include <cstddef>
#include <vector>

#include "evaluate/association.h"

namespace loopline {

struct KittiSegment {
    std::size_t first = 0, last = 0;  ///< pairs
    double length_m = 0;              ///< nominal: 100, 200, ... 800
    double translation_m = 0;         ///< error at its end
    double rotation_rad = 0;
};

struct KittiError {
    std::vector<KittiSegment> segments;
    double translation_percent = 0;  ///< mean of translation_m / length_m over all segments, times 100
    double rotation_deg_per_m = 0;
};

/// Segments begin at every tenth pose; one ends at the first pose whose way along the reference exceeds its
/// beginning's by more than its length. Errors are divided by the nominal length. Computed in double where
/// the kit uses float, and the angle from the quaternion where the kit uses acos of the trace. No segments if
/// the path is not longer than 100 m.
KittiError kitti_error(const std::vector<PosePair>& pairs);

}  // namespace loopline
