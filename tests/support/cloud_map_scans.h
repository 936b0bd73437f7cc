/// Scans of a spinning lidar that meets what a function says, vehicles that stand, and how near to each other
/// the points of a cloud are.
#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "api/stored_cloud.h"
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

/// What rounding to whole 0.1 mm may take from the distance of two points, and more.
inline constexpr double rounding_m = 2e-4;

/// Of the two points that are nearest to each other; infinite if none are within `edge_m`.
inline double nearest_two_m(const StoredCloud& cloud, double edge_m) {
    std::map<std::array<long, 3>, std::vector<Eigen::Vector3d>> cubes;
    double least_m = std::numeric_limits<double>::infinity();
    for (const CloudPoint& point : cloud.points()) {
        const Eigen::Vector3d p_m = point.p_map_m();
        std::array<long, 3> cube;
        for (int axis = 0; axis < 3; ++axis)
            cube[static_cast<std::size_t>(axis)] = std::lround(std::floor(p_m[axis] / edge_m));
        for (long x = cube[0] - 1; x <= cube[0] + 1; ++x)
            for (long y = cube[1] - 1; y <= cube[1] + 1; ++y)
                for (long z = cube[2] - 1; z <= cube[2] + 1; ++z) {
                    const auto found = cubes.find({x, y, z});
                    if (found == cubes.end()) continue;
                    for (const Eigen::Vector3d& q_m : found->second) {
                        const double d_m = (p_m - q_m).norm();
                        if (d_m < edge_m) least_m = std::min(least_m, d_m);
                    }
                }
        cubes[cube].push_back(p_m);
    }
    return least_m;
}

}  // namespace loopline::cloud_map_scans
