#include "maps/grid_drawing.h"

#include <mrpt/poses/CPose3D.h>

#include <algorithm>
#include <cmath>

namespace loopline::maps {
namespace {

using mrpt::maps::COccupancyGridMap2D;

/// MRPT grows a grid by itself as soon as a scan comes closer than 15 cells to its border: stay away from it.
constexpr double border_cells = 17;
/// MRPT keeps coordinates as floats: farther out than this many cells, they no longer tell cells apart well.
constexpr double farthest_cell = 1 << 20;
/// Room to spare, so that a grid grows seldom.
constexpr double growth_m = 10;

struct CellRange {
    int first = 0, last = -1;  ///< inclusive
    void add(int i) {
        if (last < first) first = last = i;
        first = std::min(first, i);
        last = std::max(last, i);
    }
};

}  // namespace

GridDrawing::GridDrawing(const GridSettings& settings)
    : settings_(settings), grid_(COccupancyGridMap2D::Create()) {
    const auto r = static_cast<float>(settings.resolution_m);
    grid_->setSize(-r, r, -r, r, r);
    auto& options = grid_->insertionOptions;
    options.maxDistanceInsertion = static_cast<float>(settings.max_range_m);
    options.maxOccupancyUpdateCertainty = static_cast<float>(settings.occupied_probability);
    options.maxFreenessUpdateCertainty = static_cast<float>(settings.free_probability);
    options.maxFreenessInvalidRanges = static_cast<float>(settings.free_probability);
    options.considerInvalidRangesAsFreeSpace = settings.no_return_is_free;
    options.wideningBeamsWithDistance = settings.widen_beams;
}

bool GridDrawing::insert(const PlanarScan& beams, const Pose3& T_map_sensor) {
    const double cos_tilt =
        T_map_sensor.rotation.toRotationMatrix()(2, 2);  // of the sensor's z axis to the map's
    if (std::abs(cos_tilt) < std::cos(settings_.tilt_tolerance_rad)) return false;
    const bool upside_down = cos_tilt < 0;
    Pose2 T_map_flat = T_map_sensor.planar();

    double reach_m = 0;
    for (const float range_m : beams.ranges_m) reach_m = std::max(reach_m, static_cast<double>(range_m));
    reach_m = settings_.no_return_is_free ? settings_.max_range_m : std::min(reach_m, settings_.max_range_m);
    const Eigen::Vector2d centre_m = T_map_flat.translation(), reach = Eigen::Vector2d::Constant(reach_m);
    if (reach_m <= 0 || !make_room(centre_m - reach, centre_m + reach)) return false;

    fill_observation(beams, upside_down);
    // MRPT 2.5.8 puts the first beam at phi - aperture / 2 and steps by aperture / beams, where a scan's own
    // step is aperture / (beams - 1): the last beam would be off by a whole step. With the aperture of one
    // beam more, and the pose turned so that the first beam is right, all of them are.
    const double first_rad = upside_down ? -beams.angle_rad(beams.size() - 1) : beams.first_angle_rad;
    T_map_flat.phi_rad += first_rad + 0.5 * static_cast<double>(observation_.aperture);
    const mrpt::poses::CPose3D pose(T_map_flat.x_m, T_map_flat.y_m, 0, T_map_flat.phi_rad, 0, 0);
    empty_ = false;
    return grid_->insertObservation(observation_, pose);
}

/// Beams counter-clockwise as seen from above.
void GridDrawing::fill_observation(const PlanarScan& beams, bool upside_down) {
    const std::size_t size = beams.size();
    observation_.resizeScan(size);
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t beam = upside_down ? size - 1 - i : i;
        observation_.setScanRange(i, beams.ranges_m[beam]);
        observation_.setScanRangeValidity(i, beams.has_return(beam));
    }
    observation_.aperture = static_cast<float>(beams.angle_step_rad * static_cast<double>(size));
    observation_.maxRange = static_cast<float>(beams.max_range_m);
    observation_.rightToLeft = true;
}

/// Makes the grid hold the box; false if it can't.
bool GridDrawing::make_room(const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m) {
    const double border_m = border_cells * settings_.resolution_m;
    const Eigen::Vector2d grid_low(grid_->getXMin(), grid_->getYMin()),
        grid_high(grid_->getXMax(), grid_->getYMax());
    const Eigen::Array2d need_low = low_m.array() - border_m, need_high = high_m.array() + border_m;
    if ((need_low >= grid_low.array()).all() && (need_high <= grid_high.array()).all()) return true;

    const double farthest_m = farthest_cell * settings_.resolution_m;
    if (!((need_low > -farthest_m).all() && (need_high < farthest_m).all())) return false;

    for (const double spare_m : {growth_m, 0.0}) {
        Eigen::Vector2d low = (need_low - spare_m).matrix(), high = (need_high + spare_m).matrix();
        for (int i = 0; i < 2; ++i) {  // only the sides that are too near
            if (need_low[i] >= grid_low[i]) low[i] = grid_low[i];
            if (need_high[i] <= grid_high[i]) high[i] = grid_high[i];
        }
        if (empty_) {
            low = (need_low - spare_m).matrix();
            high = (need_high + spare_m).matrix();
        }
        const Eigen::Array2d cells = ((high - low) / settings_.resolution_m).array() + 1;
        if (cells.prod() > settings_.max_cells) continue;
        const Eigen::Vector2f l = low.cast<float>(), h = high.cast<float>();
        if (empty_)
            grid_->setSize(l.x(), h.x(), l.y(), h.y(), static_cast<float>(settings_.resolution_m));
        else
            grid_->resizeGrid(l.x(), h.x(), l.y(), h.y(), 0.5f, false);
        return true;
    }
    return false;
}

COccupancyGridMap2D::Ptr GridDrawing::finish() {
    CellRange x, y;
    const auto width = static_cast<int>(grid_->getSizeX()), height = static_cast<int>(grid_->getSizeY());
    for (int row = 0; row < height; ++row) {
        const auto* cells = grid_->getRow(row);
        const auto seen = [](COccupancyGridMap2D::cellType cell) { return cell != 0; };
        const auto* first = std::find_if(cells, cells + width, seen);
        if (first == cells + width) continue;
        y.add(row);
        x.add(static_cast<int>(first - cells));
        int last = width - 1;
        while (cells[last] == 0) --last;
        x.add(last);
    }
    const auto cut = COccupancyGridMap2D::Create();
    cut->insertionOptions = grid_->insertionOptions;
    const float r = grid_->getResolution();
    if (y.last < y.first) {
        cut->setSize(-r, r, -r, r, r);
        return cut;
    }
    const auto edge = [r](float origin, int cells) { return origin + static_cast<float>(cells) * r; };
    cut->setSize(edge(grid_->getXMin(), x.first - 1), edge(grid_->getXMin(), x.last + 2),
                 edge(grid_->getYMin(), y.first - 1), edge(grid_->getYMin(), y.last + 2), r);
    for (int row = y.first; row <= y.last; ++row)
        std::copy_n(grid_->getRow(row) + x.first, x.last - x.first + 1, cut->getRow(row - y.first + 1) + 1);
    return cut;
}

}  // namespace loopline::maps
