/// Module "lidar_mapping": sweeps of a spinning lidar in, their path out.
#pragma once

#include <memory>

#include "api/module.h"
#include "lidar/observation_scan.h"
#include "lidar_mapping/sweep_mapping.h"

namespace loopline {

class LidarMappingModule : public Module {
    DEFINE_MRPT_OBJECT(LidarMappingModule, loopline)
 public:
    static constexpr const char* published_label = "lidar_mapping";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }

 private:
    lidar_mapping::SweepMappingSettings settings_;
    lidar::SweepConvention cloud_sweep_;
    std::vector<std::string> sensors_;  ///< labels; empty for all

    std::unique_ptr<lidar::SpinningScanReader> reader_;
    std::unique_ptr<lidar_mapping::SweepMapping> mapping_;
    lidar::SpinningScan scan_;
    Trajectory trajectory_;
    std::int64_t unusable_ = 0;
};

}  // namespace loopline
