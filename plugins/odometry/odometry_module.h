/// Module "odometry": dead reckoning from a log's odometry, given at the time of every scan.
#pragma once

#include <mrpt/obs/CObservationOdometry.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "api/module.h"
#include "api/observation_pool.h"
#include "api/set_aside.h"
#include "odometry/odometry_at_scans.h"

namespace loopline {

/// For every CObservation2DRangeScan it publishes one CObservationOdometry, labelled "odometry_at_scan", with
/// the scan's stamp and the scan's sequence; if asked for, for every sweep of a spinning lidar the same,
/// labelled "odometry_at_sweep", so that wheels can drive module lidar_mapping. Its trajectory is the
/// dead-reckoned pose of every scan and sweep, the first one at the origin, with a covariance that grows with
/// the way.
class Odometry : public Module {
    DEFINE_MRPT_OBJECT(Odometry, loopline)
 public:
    static constexpr const char *published_label = "odometry_at_scan", *label_at_sweep = "odometry_at_sweep";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
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
    friend void fields(Archive&, Odometry&);

    enum class Source { pose, ticks };
    struct ScanStamp {
        std::uint64_t sequence;
        StampNs stamp_ns;
        mrpt::Clock::time_point timestamp;
        bool is_sweep = false;
    };

    /// Of one scan.
    struct DeadReckoned {
        std::uint64_t sequence;
        StampNs stamp_ns;
        Pose2 T_odom_base;
    };

    void lay_out_trajectory();
    void take_odometry(const mrpt::obs::CObservationOdometry& observation, StampNs stamp_ns);
    void publish(const PlacedScan& placed, Publisher& publisher);

    Source source_ = Source::pose;
    std::string sensor_label_;
    std::vector<std::string> scan_labels_;
    bool sweeps_ = false;
    DifferentialDrive drive_;
    OdometryNoise noise_;
    OdometryAtScansSettings synchronisation_;

    OdometryAtScans at_scans_;
    std::optional<std::string> label_in_use_;
    TickUnwrapper unwrap_ticks_;
    std::optional<WheelTicks> last_ticks_;
    Pose2 T_odom_base_of_ticks_;     ///< integrated; the origin is where the first counts were read
    std::deque<ScanStamp> waiting_;  ///< in the log's order, in which they are placed
    ObservationPool<mrpt::obs::CObservationOdometry> pool_;
    SetAside<DeadReckoned> path_;
    Trajectory trajectory_;  ///< laid out at the end

    std::int64_t samples_ = 0, ignored_ = 0, without_ticks_ = 0, not_finite_ = 0, scans_ = 0,
                 by_file_order_ = 0, extrapolated_ = 0;
};

}  // namespace loopline
