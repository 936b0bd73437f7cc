#include "grid_slam/frozen_map.h"

#include <algorithm>
#include <cmath>

namespace loopline::grid_slam {
namespace {

grid_map::ScanGridSettings cells_of(double cell_m) {
    grid_map::ScanGridSettings settings;
    settings.cell_m = cell_m;
    settings.free_space = false;
    return settings;
}

/// So that all of the map is few enough cells to a side for one search.
double coarse_cell_m(const MapServerMap& map, double cell_m) {
    constexpr double least_m = 0.1, most_cells = 4000;
    const double extent_m = map.resolution_m * static_cast<double>(std::max(map.width, map.height));
    return std::max({cell_m, least_m, extent_m / most_cells});
}

std::size_t slots_for(const grid_map::CoarseOccupancy& cells) {
    const auto occupied =
        static_cast<std::size_t>(std::count(cells.cells.begin(), cells.cells.end(), MapCell::occupied));
    std::size_t slots = 1024;
    while (slots < occupied) slots *= 2;
    return slots;
}

}  // namespace

FrozenMap::FrozenMap(const MapServerMap& map, double cell_m, double reach_m)
    : cells_(grid_map::coarse_occupancy(map, cell_m)),
      T_picture_map_(map.T_map_picture.inverse()),
      grid_(cells_of(cells_.cell_m)),
      coarse_grid_(cells_of(coarse_cell_m(map, cells_.cell_m))),
      surfaces_(reach_m, cells_.cell_m, slots_for(cells_), true) {
    const grid_map::Frame frame = grid_map::surfaces_of(cells_);
    grid_.insert(frame, map.T_map_picture);
    coarse_grid_.insert(frame, map.T_map_picture);
    surfaces_.add(frame, map.T_map_picture);
    surfaces_.finish();
    surface_points_ = static_cast<std::size_t>(std::count_if(
        frame.points.begin(), frame.points.end(), [](const auto& point) { return point.has_normal(); }));
    free_cells_ =
        static_cast<std::size_t>(std::count(cells_.cells.begin(), cells_.cells.end(), MapCell::free));
    const double width_m = map.resolution_m * static_cast<double>(map.width),
                 height_m = map.resolution_m * static_cast<double>(map.height);
    lower_m_ = upper_m_ = map.T_map_picture.translation();
    for (const Eigen::Vector2d& corner :
         {Eigen::Vector2d(width_m, 0), Eigen::Vector2d(0, height_m), Eigen::Vector2d(width_m, height_m)}) {
        lower_m_ = lower_m_.cwiseMin(map.T_map_picture * corner);
        upper_m_ = upper_m_.cwiseMax(map.T_map_picture * corner);
    }
}

bool FrozenMap::may_stand(const Eigen::Vector2d& p_map_m) const {
    const Eigen::Vector2d p = T_picture_map_ * p_map_m / cells_.cell_m;
    const int x = grid_map::ScanGrid::floor_to_int(p.x()), y = grid_map::ScanGrid::floor_to_int(p.y());
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (cells_.at(x + dx, y + dy) == MapCell::free) return true;
    return false;
}

}  // namespace loopline::grid_slam
