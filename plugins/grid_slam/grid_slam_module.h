/// Module "grid_slam": scans with wheel odometry or an IMU in, path with closed loops out.
#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationIMU.h>

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/loop_closer.h"
#include "api/module.h"
#include "grid_slam/grid_slam.h"
#include "grid_slam/inertial_navigation.h"
#include "grid_slam/wheel_navigation.h"

namespace loopline {

/// Pairs each scan with the odometry of the same scan (by sequence: the odometry may come later), or waits
/// until the readings of the IMU reach beyond it, in the log's order.
class GridSlamModule : public Module, public LoopCloser {
    DEFINE_MRPT_OBJECT(GridSlamModule, loopline)
 public:
    static constexpr const char* odometry_label = "odometry_at_scan";
    static constexpr const char* published_label = "grid_slam";

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

    std::uint64_t loop_at_hand() const override {
        return slam_->loop_at_hand() && !slam_->loop_at_hand_is_refused() ? slam_->loops().size() : 0;
    }
    StampNs loop_at_hand_ns() const override { return slam_->map().stamps_ns.back(); }
    std::string refusals_key() const override { return "refuse_loops"; }
    std::string refusals() const override { return refused_loops_; }
    bool refuse_alike_before(const std::string& a, const std::string& b, StampNs loop_ns) const override;
    std::vector<std::string> loop_warnings() const override;

 private:
    template <class Archive>
    friend void fields(Archive&, GridSlamModule&);
    /// What is known of one scan so far.
    struct Scan {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        mrpt::obs::CObservation2DRangeScan::ConstPtr observation;
        std::optional<Pose2> T_odom_base;
    };
    /// What was known at its time.
    struct OnlinePose {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        Pose2 T_map_base;
    };

    enum class Source { wheel, imu, imu_wheel };

    bool is_wanted(const std::string& label) const;
    bool is_ready(const Scan& scan) const;
    void take_imu(const mrpt::obs::CObservationIMU& observation, StampNs stamp_ns);
    void take_odometry(const StreamItem& item);
    grid_map::SweepMotion sweep(const grid_slam::Prediction& prediction) const;
    grid_slam::Prediction predict(const Scan& scan);
    void move(const Pose2& T_new_old);
    void estimate(const Scan& scan, Publisher& publisher);
    void lay_out_trajectory();
    void report_loops(Results& results) const;

    grid_slam::GridSlamSettings settings_;
    Source source_ = Source::wheel;
    grid_slam::WheelNoise wheels_;
    grid_slam::InertialSettings inertial_;
    std::string imu_label_;
    std::vector<std::string> sensors_;
    bool loops_ = true;
    std::string named_loops_, refused_loops_, without_search_;  ///< as the .ini has them
    double scan_duration_s_ = 0;

    // The state: all that a break between two scans must keep.
    std::unique_ptr<grid_slam::GridSlam> slam_;
    std::deque<Scan> waiting_;                                      ///< by sequence
    std::unique_ptr<grid_slam::WheelNavigation> wheel_navigation_;  ///< of the two, the one in use
    std::unique_ptr<grid_slam::InertialNavigation> inertial_navigation_;
    std::unique_ptr<grid_slam::ReverseNavigation>
        reverse_navigation_;  ///< has no state of its own between two scans
    std::deque<OnlinePose> online_;
    std::int64_t without_odometry_ = 0, without_imu_ = 0, unusable_ = 0;

    PlanarScan beams_;
    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
