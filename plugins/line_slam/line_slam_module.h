/// Module "line_slam": extracted lines and wheel odometry in, path and map of walls out.
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "api/module.h"
#include "line_slam/assumed_drive.h"
#include "line_slam/line_ekf_slam.h"
#include "line_slam/line_input.h"
#include "line_slam/smoother.h"
#include "line_slam/wide_interval.h"

namespace loopline {

class CObservationLines;

/// Pairs the lines of a scan with the odometry of the same scan (by sequence: the odometry may come later),
/// in the log's order. Every N-th scan is a step of the filter, whose pose is published; those between two
/// steps ride on the wheels, and are fitted to both steps at the end, when the path is smoothed.
class LineSlam : public Module {
    DEFINE_MRPT_OBJECT(LineSlam, loopline)
 public:
    static constexpr const char* odometry_label = "odometry_at_scan";
    static constexpr const char* published_label = "line_slam";

    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    void start(const RunContext&) override;
    void process(const StreamItem& item, Publisher& publisher) override;
    void drain(Publisher& publisher) override;
    void finish(Results& results) override;
    const Trajectory* trajectory() const override { return &trajectory_; }
    bool can_calibrate() const override { return true; }
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    template <class Archive>
    friend void fields(Archive&, LineSlam&);
    struct Command {
        line_slam::Regime regime = line_slam::Regime::straight;
        StampNs since_ns = 0;
    };
    /// What is known of one scan so far.
    struct Scan {
        std::uint64_t sequence = 0;
        StampNs stamp_ns = 0;
        mrpt::Clock::time_point timestamp;
        std::optional<Pose2> T_odom_base;
        std::shared_ptr<const CObservationLines> lines;
        std::optional<Command> commanded;
    };
    /// Of each scan, whether a step or not.
    struct ScanPlace {
        std::uint64_t sequence;
        StampNs stamp_ns;
        Pose2 T_step_base;  ///< since the last step before it, as the filter would predict it
        line_slam::Regime regime;
        bool is_step = false;
    };
    /// What a step knew at its time.
    struct StepPose {
        Pose2 T_map_base;
        Eigen::Matrix3d covariance;  ///< of (x, y, phi)
    };

    enum class Part { lines, odometry };
    /// The scan that this item is a part of.
    Scan& waiting_scan(const StreamItem& item, Part part);
    void take_command(const std::string& text, StampNs stamp_ns);
    line_slam::ScanMotion motion_until(const Scan& scan) const;
    std::vector<line_slam::LineObservation> observations_in_base(const CObservationLines& lines) const;
    line_slam::SweepMotion sweep_motion() const;
    void estimate(Scan&& scan, Publisher& publisher);
    void step(const Scan& scan, Publisher& publisher);
    void lay_out_trajectory();
    void revise_trajectory(const line_slam::SmoothedPath& smoothed);
    Eigen::Matrix3d noise_since_step(const Pose2& T_map_step, const ScanPlace& place) const;
    void revise_between(std::size_t from, std::size_t to);
    void calibrate(Results& results) const;

    line_slam::LineSlamParameters slam_parameters_;
    line_slam::IntervalParameters interval_parameters_;
    line_slam::SmootherParameters smoother_parameters_;
    double gate_probability_ = 0.999;
    bool smoothing_ = true;
    double scan_duration_s_ = 0;
    bool calibrates_ = false;

    // The state: all that a break between two scans must keep.
    std::unique_ptr<line_slam::LineEkfSlam> slam_;
    std::unique_ptr<line_slam::WideInterval> interval_;
    std::deque<Scan> waiting_;        ///< by sequence
    std::uint64_t newest_lines_ = 0;  ///< highest sequence that brought lines
    std::optional<Scan> since_step_;  ///< the latest scan that was no step
    Pose2 T_odom_base_;               ///< at the latest scan
    double since_previous_s_ = 0;
    std::optional<Command> commanded_;
    std::deque<ScanPlace> places_;
    std::vector<StepPose> steps_;
    line_slam::SlamStatus status_ = line_slam::SlamStatus::good;
    std::int64_t without_odometry_ = 0;

    line_slam::Drive drive_;  ///< for a calibration, which no checkpoint interrupts

    Trajectory trajectory_;  ///< laid out at the end: thousands of scans ride between steps
};

}  // namespace loopline
