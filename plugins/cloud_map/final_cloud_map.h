/// Map builder "final_cloud_map": the cloud of module cloud_map by the final poses, for trajectories that are
/// revised after their time, by loops that are closed or by positions from outside.
#pragma once

#include "api/map_maker.h"
#include "cloud_map/cloud_map_options.h"
#include "cloud_map/pose_window.h"

namespace loopline {

class FinalCloudMapBuilder : public MapBuilder, public MapMaker {
    DEFINE_MRPT_OBJECT(FinalCloudMapBuilder, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override { return options_.check(); }
    void start(const RunContext& context, const Trajectory& trajectory) override;
    void insert(const StreamItem& item) override;
    void finish(Results& results) override;

    void leave_out_map() override { wanted_ = false; }
    const StoredCloud* cloud() const override { return mapper_ ? &mapper_->cloud() : nullptr; }

 private:
    cloud_map::PoseWindow path_about(const cloud_map::TimedSweep& sweep, std::uint64_t sequence) const;

    cloud_map::CloudMapOptions options_;
    bool wanted_ = true;
    const Trajectory* trajectory_ = nullptr;
    std::unique_ptr<lidar::SpinningScanReader> reader_;
    std::unique_ptr<cloud_map::CloudMapper> mapper_;
    cloud_map::TimedSweep sweep_;
    cloud_map::SweepCounts counts_;
};

}  // namespace loopline
