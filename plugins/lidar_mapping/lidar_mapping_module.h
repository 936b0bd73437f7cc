/// Module "lidar_mapping": sweeps of a spinning lidar in, their path out.
#pragma once

#include <array>
#include <memory>

#include "api/module.h"
#include "api/pose3_record.h"
#include "api/set_aside.h"
#include "api/timed_per.h"
#include "lidar/observation_scan.h"
#include "lidar_mapping/published_odometry.h"
#include "lidar_mapping/sweep_mapping.h"

namespace loopline {

class LidarMappingModule : public Module, public TimedPerSweep {
    DEFINE_MRPT_OBJECT(LidarMappingModule, loopline)
 public:
    static constexpr const char* published_label = "lidar_mapping";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void drain(Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    template <class Archive>
    friend void fields(Archive&, LidarMappingModule&);
    struct Sweep {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose3Record T_map_base;
        std::array<double, 36> covariance{};
    };
    /// A sweep on its way; with an odometry it waits for the pose of its time.
    struct Waiting {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        mrpt::Clock::time_point timestamp;
        lidar::SpinningScan scan;
    };
    struct Placed {
        lidar_mapping::MotionState state;  ///< in the middle of the sweep
        Matrix6d covariance = Matrix6d::Zero();
    };
    void follow(const Waiting& sweep, Publisher& publisher);
    Placed place(const lidar::SpinningScan& scan, StampNs middle_ns);
    void follow_waiting(Publisher& publisher);
    void publish(const Waiting& sweep, const Pose3& T_map_base, const Matrix6d& covariance,
                 Publisher& publisher) const;

    lidar_mapping::SweepMappingSettings settings_;
    lidar::SweepConvention cloud_sweep_;
    std::vector<std::string> sensors_;  ///< labels; empty for all
    lidar_mapping::PublishedOdometrySettings odometry_settings_;
    int every_sweeps_ = 1;

    std::unique_ptr<lidar::SpinningScanReader> reader_;
    std::unique_ptr<lidar_mapping::SweepMapping> mapping_;
    std::unique_ptr<lidar_mapping::PublishedOdometry> odometry_;
    Waiting now_;
    bool waits_ = false;  ///< the sweep in now_
    int between_ = 0;     ///< sweeps since the latest one of the map
    SetAside<Sweep> sweeps_;
    std::int64_t unusable_ = 0, degenerate_ = 0;

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
