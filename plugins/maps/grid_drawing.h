/// Draws an occupancy grid from scans at known poses, by MRPT's COccupancyGridMap2D.
#pragma once

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include "api/planar_scan.h"
#include "api/pose3.h"

namespace loopline::maps {

struct GridSettings {
    double resolution_m = 0.05;
    double max_range_m = 30;  ///< cells beyond it stay as they are; a longer beam only clears its way
    double occupied_probability =
        0.65;  ///< evidence of one return; MRPT counts it three times for the cell it hit
    double free_probability = 0.65;  ///< evidence of one beam passing
    bool no_return_is_free = false;  ///< a beam without return clears half the way of the last one with
    bool widen_beams = false;        ///< a beam as a wedge as wide as its angle step, not as a ray
    double tilt_tolerance_rad = 5 * M_PI / 180;
    int max_cells = 100'000'000;
};

/// Grows with what it draws, up to `max_cells` (a byte each): a scan at an absurd pose is left out, not
/// allocated for.
class GridDrawing {
 public:
    explicit GridDrawing(const GridSettings& settings);

    /// False if the scan was left out: it is tilted by more than the tolerance (the grid is a horizontal
    /// cut), or the grid would need too many cells. A sensor that is mounted upside down is fine.
    bool insert(const PlanarScan& beams, const Pose3& T_map_sensor);

    /// The grid, cut to the cells that were seen and one around them. Call it once, at the end.
    mrpt::maps::COccupancyGridMap2D::Ptr finish();

 private:
    void fill_observation(const PlanarScan& beams, bool upside_down);
    bool make_room(const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m);

    GridSettings settings_;
    mrpt::maps::COccupancyGridMap2D::Ptr grid_;
    bool empty_ = true;
    mrpt::obs::CObservation2DRangeScan observation_;
};

}  // namespace loopline::maps
