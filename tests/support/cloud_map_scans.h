/// Scans of a spinning lidar that meets what a function says, and vehicles that stand.
#pragma once

#include <cmath>

#include "cloud_map/sweep_motion.h"

namespace loopline::cloud_map_scans {

inline constexpr StampNs start_ns = 1'400'000'000'000'000'000;

/// As if all beams met something at ranges that `range_m(elevation, azimuth)` gives; 0 for nothing.
template <class Range>
lidar::SpinningScan scan_of(const Range& range_m, int columns = 900) {
    lidar::SpinningScan scan;
    scan.stamp_ns = start_ns;
    scan.end_s = 0.1;
    for (int ring = 0; ring < 32; ++ring) {
        const double e = (10 - 1.33 * ring) * M_PI / 180;
        scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
        for (int k = 0; k < columns; ++k) {
            const double a = M_PI - 2 * M_PI * (k + 0.5) / columns, r = range_m(e, a);
            if (!(r > 0)) continue;
            scan.points.push_back({static_cast<float>(r * std::cos(e) * std::cos(a)),
                                   static_cast<float>(r * std::cos(e) * std::sin(a)),
                                   static_cast<float>(r * std::sin(e)),
                                   static_cast<float>(0.1 * k / columns)});
        }
    }
    scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
    return scan;
}

inline cloud_map::PoseAt standing(const Pose3& T_map_base = {}) {
    return [T_map_base](StampNs) { return T_map_base; };
}

}  // namespace loopline::cloud_map_scans
