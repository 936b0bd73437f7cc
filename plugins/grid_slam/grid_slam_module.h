/// Module "grid_slam": scans and wheel odometry in, path with closed loops out.
#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/module.h"
#include "grid_slam/grid_slam.h"

namespace loopline {

/// Pairs each scan with the odometry of the same scan (by sequence: the odometry may come later), in the log's order.
class GridSlamModule : public Module {
    DEFINE_MRPT_OBJECT(GridSlamModule, loopline)
 public:
    static constexpr const char* odometry_label = "odometry_at_scan";
    static constexpr const char* published_label = "grid_slam";

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

    bool is_wanted(const std::string& label) const;
    void take_odometry(const StreamItem& item);
    void estimate(const Scan& scan, Publisher& publisher);
    void lay_out_trajectory();
    void report_loops(Results& results) const;

    grid_slam::GridSlamSettings settings_;
    grid_slam::WheelNoise wheels_;
    std::vector<std::string> sensors_;
    bool loops_ = true;

    // The state: all that a break between two scans must keep.
    std::unique_ptr<grid_slam::GridSlam> slam_;
    std::deque<Scan> waiting_;  ///< by sequence
    std::optional<Pose2> T_odom_base_;  ///< at the latest scan
    std::deque<OnlinePose> online_;
    std::int64_t without_odometry_ = 0, unusable_ = 0;

    PlanarScan beams_;
    Trajectory trajectory_;  ///< laid out at the end
};

}  // namespace loopline
