/// Map builder "points": the scan points at their final poses, thinned.
#pragma once

#include <mrpt/maps/CSimplePointsMap.h>

#include <memory>

#include "api/module.h"
#include "maps/scan_in_map.h"
#include "maps/voxel_set.h"

namespace loopline {

class PointsMapBuilder : public MapBuilder {
    DEFINE_MRPT_OBJECT(PointsMapBuilder, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&, const Trajectory& trajectory) override;
    void insert(const StreamItem& item) override;
    void finish(Results& results) override;
    bool wants_dead_reckoning() const override { return true; }

 private:
    std::vector<std::string> sensors_;
    double spacing_m_ = 0.05;
    double max_range_m_ = 80;
    int max_points_ = 10'000'000;

    const Trajectory* trajectory_ = nullptr;
    mrpt::maps::CSimplePointsMap::Ptr points_;
    std::shared_ptr<maps::VoxelSet> taken_;
    maps::ScanInMap scan_;
    std::int64_t left_out_ = 0;
};

}  // namespace loopline
