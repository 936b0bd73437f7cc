/// A finished map that scans are matched with and that nothing is added to.
#pragma once

#include "api/map_server_map.h"
#include "grid_map/occupancy_surfaces.h"
#include "grid_map/scan_grid.h"
#include "grid_map/surface_index.h"

namespace loopline::grid_slam {

class FrozenMap {
 public:
    /// `cell_m`: cells of a finer map are taken together up to this edge. `reach_m`: the longest distance of
    /// a return from its surface.
    FrozenMap(const MapServerMap& map, double cell_m, double reach_m);

    /// For the search around a place, at cell_m().
    const grid_map::ScanGrid& grid() const { return grid_; }
    /// For the search over all of the map: cells of at least 0.1 m.
    const grid_map::ScanGrid& coarse_grid() const { return coarse_grid_; }
    const grid_map::SurfaceIndex& surfaces() const { return surfaces_; }
    double cell_m() const { return cells_.cell_m; }
    std::size_t surface_points() const { return surface_points_; }
    std::size_t free_cells() const { return free_cells_; }

    /// Whether a vehicle can be there: the place or one of the cells around it is free.
    bool may_stand(const Eigen::Vector2d& p_map_m) const;
    /// The rectangle along the axes of the map that holds all of it.
    const Eigen::Vector2d& lower_m() const { return lower_m_; }
    const Eigen::Vector2d& upper_m() const { return upper_m_; }

 private:
    grid_map::CoarseOccupancy cells_;
    Pose2 T_picture_map_;
    grid_map::ScanGrid grid_, coarse_grid_;
    grid_map::SurfaceIndex surfaces_;
    std::size_t surface_points_ = 0, free_cells_ = 0;
    Eigen::Vector2d lower_m_, upper_m_;
};

}  // namespace loopline::grid_slam
