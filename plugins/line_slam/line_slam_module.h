/// Module "line_slam": extracted lines and wheel odometry in, path and map of walls out.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "api/module.h"
#include "line_slam/line_ekf_slam.h"
#include "line_slam/smoother.h"

namespace loopline {

class CObservationLines;

/// Pairs the lines of a scan with the odometry of the same scan (by sequence; by stamp where both come from a
/// recorded log: the odometry may come later), feeds the filter in the log's order, and publishes the
/// filter's pose of every scan. At the end the path is smoothed.
class LineSlam : public Module {
    DEFINE_MRPT_OBJECT(LineSlam, loopline)
 public:
    static constexpr const char* odometry_label = "odometry_at_scan";
    static constexpr const char* published_label = "line_slam";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void drain(Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }

 private:
    /// What is known of one scan so far.
    struct Scan {
        StampNs stamp_ns = 0;
        mrpt::Clock::time_point timestamp;
        std::optional<Pose2> T_odom_base;
        std::optional<std::vector<line_slam::LineObservation>> lines;
    };

    enum class Part { lines, odometry };
    /// The scan that this item is a part of, with its sequence.
    std::pair<const std::uint64_t, Scan>& scan_of(const StreamItem& item, Part part);
    void take_lines(const CObservationLines& observation, Scan& scan) const;
    void estimate(std::uint64_t sequence, const Scan& scan, Publisher& publisher);
    void revise_trajectory(const line_slam::SmoothedPath& smoothed);

    line_slam::LineSlamParameters slam_parameters_;
    line_slam::SmootherParameters smoother_parameters_;
    double gate_probability_ = 0.999;
    bool smoothing_ = true;

    // The state: all that a break between two scans must keep.
    std::unique_ptr<line_slam::LineEkfSlam> slam_;
    std::map<std::uint64_t, Scan> waiting_;     ///< by sequence
    std::uint64_t newest_lines_ = 0;            ///< highest sequence that brought lines
    std::optional<std::uint64_t> newest_item_;  ///< highest sequence so far
    std::optional<Pose2> T_odom_previous_;
    Trajectory trajectory_;
    line_slam::SlamStatus status_ = line_slam::SlamStatus::good;
    std::int64_t without_odometry_ = 0;
};

}  // namespace loopline
