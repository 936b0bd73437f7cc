/// Module "lidar_mapping": sweeps of a spinning lidar in, their path out.
#pragma once

#include <array>
#include <memory>

#include "api/module.h"
#include "api/pose3_record.h"
#include "api/set_aside.h"
#include "api/timed_per.h"
#include "lidar_mapping/led_sweeps.h"
#include "lidar_mapping/sweep_mapping.h"

namespace loopline {

class LidarMappingModule : public Module, public TimedPerSweep {
    DEFINE_MRPT_OBJECT(LidarMappingModule, loopline)
 public:
    /// The second: now and then, just before a pose, the turn that brings the map's axes upright, by walls
    /// around; what is not known of it, the heading and a place, has a standard deviation of 1000.
    static constexpr const char *published_label = "lidar_mapping", *upright_label = "lidar_mapping_upright";

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
    struct Placed {
        lidar_mapping::MotionState state;  ///< in the middle of the sweep
        Matrix6d covariance = Matrix6d::Zero();
    };
    void follow(const lidar_mapping::LedSweeps::Sweep& sweep, Publisher& publisher);
    Placed place(const lidar::SpinningScan& scan, StampNs middle_ns);
    void look_for_upright(const lidar_mapping::LedSweeps::Sweep& sweep, const Pose3& T_map_base,
                          Publisher& publisher);
    void publish(const lidar_mapping::LedSweeps::Sweep& sweep, const Pose3& T_map_base,
                 const Matrix6d& covariance, Publisher& publisher) const;

    lidar_mapping::SweepMappingSettings settings_;
    lidar_mapping::LedSweepsSettings led_settings_;
    int every_sweeps_ = 1;

    std::unique_ptr<lidar_mapping::LedSweeps> led_;
    std::unique_ptr<lidar_mapping::SweepMapping> mapping_;
    int between_ = 0;  ///< sweeps since the latest one of the map
    SetAside<Sweep> sweeps_;
    double way_m_ = 0, upright_due_m_ = 10;
    std::int64_t degenerate_ = 0;

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
