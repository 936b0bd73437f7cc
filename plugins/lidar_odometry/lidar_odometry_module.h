/// Module "lidar_odometry": sweeps of a spinning lidar in, its motion from sweep to sweep out.
#pragma once

#include <array>
#include <memory>

#include "api/module.h"
#include "api/pose3_record.h"
#include "api/set_aside.h"
#include "api/timed_per.h"
#include "lidar/observation_scan.h"
#include "lidar_odometry/sweep_odometry.h"

namespace loopline {

/// For every sweep it publishes the pose since the first sweep with its covariance, and from the second on
/// the motion since the sweep before: both as CObservationRobotPose, the latter labelled `motion_label`, with
/// the sensor's frame at the sweep before as its map.
class LidarOdometryModule : public Module, public TimedPerSweep {
    DEFINE_MRPT_OBJECT(LidarOdometryModule, loopline)
 public:
    static constexpr const char* published_label = "lidar_odometry";
    static constexpr const char* motion_label = "lidar_odometry_motion";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    template <class Archive>
    friend void fields(Archive&, LidarOdometryModule&);
    struct Sweep {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose3Record T_map_base;
        std::array<double, 36> covariance{};
    };
    void publish(const StreamItem& item, Publisher& publisher);
    void count(const lidar_odometry::MatchedMotion& motion);

    lidar_odometry::SweepOdometrySettings settings_;
    lidar::SweepConvention cloud_sweep_;
    std::string sensor_label_;

    std::unique_ptr<lidar::SpinningScanReader> reader_;
    std::unique_ptr<lidar_odometry::SweepOdometry> odometry_;
    lidar::SpinningScan scan_;
    std::string label_in_use_;  ///< empty before the first sweep, and where sweeps have no label
    SetAside<Sweep> sweeps_;
    Pose3 T_map_last_;  ///< at the latest stamp

    std::int64_t unusable_ = 0, backwards_ = 0, other_sensors_ = 0, degenerate_ = 0, unconverged_ = 0;
    std::array<std::int64_t, 6>
        free_{};  ///< sweeps that leave x, y, z, roll, pitch, yaw free before all others
    std::int64_t lines_ = 0, planes_ = 0;
    double weakest_sigma_m_ = 0;

    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
