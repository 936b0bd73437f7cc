/// Module "cloud_map": sweeps of a spinning lidar and the poses of a module before it in, the cloud of all
/// that stands still out.
#pragma once

#include <deque>
#include <memory>

#include "api/map_maker.h"
#include "api/module.h"
#include "api/timed_per.h"
#include "cloud_map/cloud_map_options.h"
#include "cloud_map/pose_window.h"

namespace loopline {

/// A sweep waits for the pose that ends it, mostly the next sweep's.
class CloudMapModule : public Module, public MapMaker, public TimedPerSweep {
    DEFINE_MRPT_OBJECT(CloudMapModule, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher&) override;
    void finish(Results& results) override;
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

    void leave_out_map() override { wanted_ = false; }
    const StoredCloud* cloud() const override { return mapper_ ? &mapper_->cloud() : nullptr; }
    std::string carried_by() const override { return poses_; }

 private:
    template <class Archive>
    friend void fields(Archive&, CloudMapModule&);
    void take_pose(const StreamItem& item);
    void take_sweep(const StreamItem& item);
    void map_first_waiting();

    cloud_map::CloudMapOptions options_;
    std::string poses_ = "lidar_mapping";  ///< their label
    bool wanted_ = true;

    std::unique_ptr<lidar::SpinningScanReader> reader_;
    std::unique_ptr<cloud_map::CloudMapper> mapper_;
    cloud_map::PoseWindow path_;
    std::deque<cloud_map::TimedSweep> waiting_;
    cloud_map::SweepCounts counts_;
};

}  // namespace loopline
