#include "maps/grid_module.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(GridMapBuilder, MapBuilder, loopline)

ModuleInfo GridMapBuilder::info() const {
    return {"grid",
            "Draws an occupancy grid from all scans at their final poses.",
            {"CObservation2DRangeScan"},
            {},
            {}};
}

ParameterTable GridMapBuilder::parameters() {
    return ParameterTable("grid", info().sentence)
        .list("sensors", sensors_, "Labels of the lasers whose scans are used; empty for all.")
        .real("resolution_m", settings_.resolution_m, {0.001, 10}, "Edge of a cell.")
        .real("max_range_m", settings_.max_range_m, {0.1, 1000},
              "Cells farther from the sensor stay as they are; a longer beam only clears its way.")
        .real(
            "occupied_probability", settings_.occupied_probability, {0.51, 0.99},
            "Evidence that one return gives for an occupied cell (counted three times for the cell it hit).")
        .real("free_probability", settings_.free_probability, {0.51, 0.99},
              "Evidence that one passing beam gives for a free cell.")
        .boolean(
            "no_return_is_free", settings_.no_return_is_free,
            "A beam without return clears half the way of the last beam with one; wrong on glass and black.")
        .boolean("widen_beams", settings_.widen_beams,
                 "Draws a beam as a wedge as wide as its angle step; fills gaps far away, costs about three "
                 "times the time.")
        .angle("tilt_tolerance_deg", settings_.tilt_tolerance_rad, {0, 45},
               "Scans whose plane is tilted more are left out, since the grid is a horizontal cut.")
        .integer("max_cells", settings_.max_cells, {100, 2e9},
                 "Scans that would need a larger grid are left out; a cell takes one byte.");
}

void GridMapBuilder::start(const RunContext&, const Trajectory& trajectory) {
    trajectory_ = &trajectory;
    drawing_ = std::make_shared<maps::GridDrawing>(settings_);
    scans_left_out_ = 0;
}

void GridMapBuilder::insert(const StreamItem& item) {
    if (scan_.take(item, *trajectory_, sensors_) && !drawing_->insert(scan_.beams(), scan_.T_map_sensor()))
        ++scans_left_out_;
}

void GridMapBuilder::finish(Results& results) {
    const auto grid = drawing_->finish();
    results.metrics["grid_cells"] = static_cast<std::int64_t>(grid->getSizeX()) * grid->getSizeY();
    if (scans_left_out_ > 0) results.metrics["grid_scans_left_out"] = scans_left_out_;
    results.maps.push_back({info().name, grid});
    drawing_.reset();
}

}  // namespace loopline
