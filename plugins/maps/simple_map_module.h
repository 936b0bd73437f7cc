/// Map builder "simplemap": scans with their final poses, as MRPT's own programs take them.
#pragma once

#include <mrpt/maps/CSimpleMap.h>

#include <map>
#include <string>

#include "api/module.h"
#include "maps/scan_in_map.h"

namespace loopline {

class SimpleMapBuilder : public MapBuilder {
    DEFINE_MRPT_OBJECT(SimpleMapBuilder, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&, const Trajectory& trajectory) override;
    void insert(const StreamItem& item) override;
    void finish(Results& results) override;

 private:
    bool is_keyframe(const Pose3& T_map_base, const Pose3& T_map_last) const;

    std::vector<std::string> sensors_;
    double distance_m_ = 0.5;
    double angle_rad_ = 15 * M_PI / 180;
    int max_keyframes_ = 100'000;

    const Trajectory* trajectory_ = nullptr;
    mrpt::maps::CSimpleMap::Ptr map_;
    std::map<std::string, Pose3> T_map_last_;  ///< last keyframe's vehicle pose, by sensor label
    maps::ScanInMap scan_;
    std::int64_t left_out_ = 0;
};

}  // namespace loopline
