/// Distance of a point from a segment in the plane.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace loopline::simulation {

/// From `point_m` to the nearest point between `a_m` and `b_m`, which may be one place.
inline double distance_to_segment_m(const Eigen::Vector2d& point_m, const Eigen::Vector2d& a_m,
                                    const Eigen::Vector2d& b_m) {
    const Eigen::Vector2d way_m = b_m - a_m;
    const double length2 = way_m.squaredNorm();
    const double part = length2 > 0 ? std::clamp((point_m - a_m).dot(way_m) / length2, 0.0, 1.0) : 0;
    return (a_m + part * way_m - point_m).norm();
}

}  // namespace loopline::simulation
