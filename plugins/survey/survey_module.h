/// Map builder "survey": the cloud of a laser that is carried along and tilted, every beam at the pose of its
/// own time.
#pragma once

#include <mrpt/maps/CSimplePointsMap.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/module.h"
#include "maps/voxel_set.h"
#include "survey/sweep_fusion.h"

namespace loopline {

/// A scan is fused when the next one of its sensor has come, whose sensorPose tells how the mount moved
/// meanwhile.
class SurveyMapBuilder : public MapBuilder {
    DEFINE_MRPT_OBJECT(SurveyMapBuilder, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    void start(const RunContext&, const Trajectory& trajectory) override;
    void insert(const StreamItem& item) override;
    void finish(Results& results) override;
    bool wants_dead_reckoning() const override { return true; }

 private:
    struct Sensor {
        std::optional<survey::TimedScan> previous, waiting;
    };
    void fuse_waiting(Sensor& sensor, const survey::TimedScan* next);

    std::vector<std::string> sensors_;
    double scan_duration_s_ = 0;
    survey::RangeGate gate_{0.05, 100};
    double max_gap_s_ = 0.5;
    double spacing_m_ = 0;
    int max_points_ = 20'000'000;

    std::unique_ptr<PathSampler> T_map_base_;
    std::map<std::string, Sensor> by_label_;
    std::vector<Eigen::Vector3f> fused_;  ///< of one scan
    mrpt::maps::CSimplePointsMap::Ptr cloud_;
    std::unique_ptr<maps::VoxelSet> taken_;  ///< null: no thinning
    survey::FusionCounts counts_;
    std::int64_t scans_ = 0, thinned_ = 0, over_limit_ = 0;
};

}  // namespace loopline
