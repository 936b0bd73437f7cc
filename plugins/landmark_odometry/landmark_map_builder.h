/// Map builder "landmarks": trunks, poles or reflectors where sightings by the final path have them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/module.h"
#include "landmark_odometry/landmark_map.h"
#include "landmark_odometry/sightings.h"

namespace loopline {

class LandmarkMapBuilder : public MapBuilder {
    DEFINE_MRPT_OBJECT(LandmarkMapBuilder, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&, const Trajectory& trajectory) override;
    void insert(const StreamItem& item) override;
    void finish(Results& results) override;
    bool wants_dead_reckoning() const override { return true; }

 private:
    std::vector<std::string> sensors_;
    landmark_odometry::SightingSettings sightings_;
    double join_m_ = 1.5;
    int least_sightings_ = 10;

    const Trajectory* trajectory_ = nullptr;
    std::optional<landmark_odometry::LandmarkMap> map_;
    double ground_m_ = 0;  ///< height of the vehicle, for what has none: mean over all scans
    std::int64_t scans_ = 0;
};

}  // namespace loopline
