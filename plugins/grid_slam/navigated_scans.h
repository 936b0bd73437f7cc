/// What the modules on grids have in common: scans wait until the odometry or the IMU has come up to them,
/// and navigation tells where the vehicle should be at each.
#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/module.h"
#include "grid_slam/forward_match.h"
#include "grid_slam/inertial_navigation.h"
#include "grid_slam/wheel_navigation.h"

namespace loopline::grid_slam {

/// Pairs each scan with the odometry of the same scan (by sequence: the odometry may come later), or waits
/// until the readings of the IMU reach beyond it, in the log's order.
class NavigatedScans {
 public:
    static constexpr const char* odometry_label = "odometry_at_scan";
    enum class Source { wheel, imu, imu_wheel };
    /// What is known of one scan so far.
    struct Scan {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        mrpt::obs::CObservation2DRangeScan::ConstPtr observation;
        std::optional<Pose2> T_odom_base;
    };

    /// Rows of the section of a module: which scans, and what is known of the motion between them.
    void declare(ParameterTable& table);
    void declare_imu(ParameterTable& table);
    void add_needs(ModuleInfo& info) const;
    /// `keep_readings`: of the IMU, for those who go back.
    void start(bool keep_readings);

    /// Takes an observation, and calls estimate(scan) for each scan that has waited long enough, as long as
    /// it says to go on with the next one; the others wait for the next observation.
    template <class Estimate>
    void take(const StreamItem& item, const Estimate& estimate) {
        take(item);
        bool goes_on = true;
        while (goes_on && !waiting_.empty() && is_ready(waiting_.front())) {
            goes_on = estimate(waiting_.front());
            waiting_.pop_front();
        }
    }
    /// At the end of the log.
    template <class Estimate>
    void drain(const Estimate& estimate) {
        for (const Scan& scan : waiting_) estimate(scan);
        waiting_.clear();
    }

    /// The beams of a scan; null, which is counted, if it can't be used.
    const PlanarScan* beams(const Scan& scan);
    Prediction predict(const Scan& scan);
    /// As the vehicle moved since the scan before.
    grid_map::SweepMotion sweep(const Prediction& prediction) const;
    void update(const Scan& scan, const ForwardMatch& match);
    /// The map was corrected, and the vehicle moved with it.
    void move(const Pose2& T_new_old);
    /// Null where there is none.
    const InertialNavigation* inertial() const { return inertial_navigation_.get(); }
    void report(std::map<std::string, MetricValue>& metrics) const;

 private:
    template <class Archive>
    friend void fields(Archive&, NavigatedScans&);
    void take(const StreamItem& item);
    bool is_wanted(const std::string& label) const;
    bool is_ready(const Scan& scan) const;
    void take_imu(const mrpt::obs::CObservationIMU& observation, StampNs stamp_ns);
    void take_odometry(const StreamItem& item);

    Source source_ = Source::wheel;
    WheelNoise wheels_;
    InertialSettings settings_;
    std::string imu_label_;
    std::vector<std::string> sensors_;
    double scan_duration_s_ = 0;

    // The state.
    std::deque<Scan> waiting_;                           ///< by sequence
    std::unique_ptr<WheelNavigation> wheel_navigation_;  ///< of the two, the one in use
    std::unique_ptr<InertialNavigation> inertial_navigation_;
    std::int64_t without_odometry_ = 0, without_imu_ = 0, unusable_ = 0;
    PlanarScan beams_;
};

/// Rows of how a scan is matched with what is around it.
void declare_matching(ParameterTable& table, grid_map::FrameSettings& frame, ForwardSettings& forward);
/// A noisier laser tells the direction of a surface from a longer piece of it only, and scatters more about
/// it.
void fit_surfaces_to_noise(grid_map::FrameSettings& frame, double sigma_return_m);

/// What a module publishes of a scan's pose; the covariance is of (x, y, phi), map axes.
mrpt::obs::CObservationRobotPose::Ptr pose_observation(const std::string& label, const Pose2& T_map_base,
                                                       const Eigen::Matrix3d& covariance);

}  // namespace loopline::grid_slam
