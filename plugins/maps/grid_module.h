/// Map builder "grid": an occupancy grid from the final poses.
#pragma once

#include <memory>

#include "api/module.h"
#include "maps/grid_drawing.h"
#include "maps/scan_in_map.h"

namespace loopline {

class GridMapBuilder : public MapBuilder {
    DEFINE_MRPT_OBJECT(GridMapBuilder, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&, const Trajectory& trajectory) override;
    void insert(const StreamItem& item) override;
    void finish(Results& results) override;

 private:
    std::vector<std::string> sensors_;
    maps::GridSettings settings_;
    const Trajectory* trajectory_ = nullptr;
    std::shared_ptr<maps::GridDrawing> drawing_;
    maps::ScanInMap scan_;
    std::int64_t scans_left_out_ = 0;
};

}  // namespace loopline
