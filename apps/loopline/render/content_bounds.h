/// The part of the world that a picture shows.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "render/figure.h"
#include "render/scene_content.h"

namespace loopline {

/// An axis-aligned box in the map frame; empty until something finite was added.
struct Bounds {
    Eigen::Vector3d low_m = Eigen::Vector3d::Constant(INFINITY);
    Eigen::Vector3d high_m = Eigen::Vector3d::Constant(-INFINITY);

    bool empty() const { return !(low_m.x() <= high_m.x()); }
    Eigen::Vector3d centre_m() const { return (low_m + high_m) / 2; }
    Eigen::Vector3d extent_m() const { return high_m - low_m; }
    void add(const Eigen::Vector3d& p_map) {
        if (!p_map.allFinite()) return;
        low_m = low_m.cwiseMin(p_map);
        high_m = high_m.cwiseMax(p_map);
    }
    void add(const Bounds& other) {
        low_m = low_m.cwiseMin(other.low_m);
        high_m = high_m.cwiseMax(other.high_m);
    }
};

Bounds bounds_of_path(const std::vector<Pose3>& path);
/// Of all but the 1.5 % of points farthest out in each direction: stray returns must not shrink the map.
Bounds bounds_of_points(const std::vector<Eigen::Vector3f>& points_m);
Bounds bounds_of_lines(const LineMap& lines);
/// Of the known cells.
Bounds bounds_of_grid(const mrpt::maps::COccupancyGridMap2D& grid);
/// Of all that the estimate has to show; of the odometry path too.
Bounds bounds_of(const SceneContent& content);

/// The window on `bounds` that fits into `box` with a margin; a window on nothing, or on one point, is some
/// metres wide.
MapWindow fitting_window(const Bounds& bounds, const Box& box);

}  // namespace loopline
