/// The surfaces of an occupancy grid that nothing but its cells is known of: where occupied cells border on
/// free ones, with the normal that their neighbours give, on each side that is free.
#pragma once

#include "api/map_server_map.h"
#include "grid_map/frame.h"

namespace loopline::grid_map {

/// Cells of several map cells to a side.
struct CoarseOccupancy {
    int width = 0, height = 0;
    double cell_m = 0;
    std::vector<MapCell> cells;            ///< occupied if any of them is, else free if any is
    std::vector<Eigen::Vector2d> means_m;  ///< of the occupied ones, in the frame of the picture

    MapCell at(int x, int y) const {
        return x < 0 || y < 0 || x >= width || y >= height ? MapCell::unknown : cells[index(x, y)];
    }
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

/// With the largest cells that are whole cells of the map and no longer than `cell_m`; the map's own if these
/// are longer.
CoarseOccupancy coarse_occupancy(const MapServerMap& map, double cell_m);

/// The points are in the frame of the picture. A wall of one cell between two free sides gives two points
/// with opposite normals; at corners, and where cells scatter, there is a point without a normal.
Frame surfaces_of(const CoarseOccupancy& map);

}  // namespace loopline::grid_map
