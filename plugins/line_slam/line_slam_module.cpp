#include "line_slam/line_slam_module.h"

#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cmath>

#include "api/twist2.h"
#include "least_squares/chi_square.h"
#include "line_slam/calibration_section.h"
#include "line_slam/line_input.h"
#include "lines/observation_lines.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LineSlam, Module, loopline)

namespace {

using namespace line_slam;

mrpt::obs::CObservationRobotPose::Ptr pose_observation(const Pose2& T_map_base,
                                                       const Eigen::Matrix3d& covariance) {
    auto observation = mrpt::obs::CObservationRobotPose::Create();
    observation->sensorLabel = LineSlam::published_label;
    observation->pose.mean =
        mrpt::poses::CPose3D(T_map_base.x_m, T_map_base.y_m, 0, T_map_base.phi_rad, 0, 0);
    observation->pose.cov.setZero();
    constexpr int index[3] = {0, 1, 3};  // x, y, yaw of MRPT's (x y z yaw pitch roll)
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            observation->pose.cov(index[row], index[column]) = covariance(row, column);
    return observation;
}

/// What a log's comments say when the regime changes.
constexpr const char* command_words[regime_count] = {"straight", "left", "right"};

MapLine map_line(const PlanarLine& line, const Eigen::Matrix2d& covariance, const Extent& extent,
                 int observations, std::uint64_t id) {
    MapLine m;
    m.id = id;
    m.rho_m = line.rho_m;
    m.alpha_rad = line.alpha_rad;
    m.covariance = covariance;
    m.start_m = line.point_m(extent.from_m);
    m.end_m = line.point_m(extent.to_m);
    m.observations = observations;
    return m;
}

}  // namespace

ModuleInfo LineSlam::info() const {
    return {"line_slam",
            "EKF-SLAM on straight walls and wheel odometry, smoothed at the end of the log.",
            {"CObservationLines", "CObservationOdometry"},
            {"CObservationComment"},
            {"CObservationRobotPose"}};
}

void LineSlam::start(const RunContext& context) {
    calibrates_ = context.calibrates;
    trajectory_.keep_in(context.scratch_folder);
    const double gate = least_squares::chi_square_quantile(2, gate_probability_);
    slam_parameters_.association.gate = gate;
    slam_parameters_.association.probability = gate_probability_;
    slam_parameters_.tentative.gate = gate;
    slam_parameters_.tentative.max_gap_m = slam_parameters_.association.max_gap_m;
    smoother_parameters_.pairing.gate = gate;
    smoother_parameters_.pairing.max_gap_m = slam_parameters_.association.max_gap_m;
    smoother_parameters_.min_observations = slam_parameters_.tentative.scans;
    slam_ = std::make_unique<LineEkfSlam>(slam_parameters_);
    interval_ = std::make_unique<WideInterval>(interval_parameters_, slam_parameters_.drive);
}

LineSlam::Scan& LineSlam::waiting_scan(const StreamItem& item, Part part) {
    // What a module publishes carries the sequence of its scan; what a log holds has its own.
    if (!item.published)
        for (Scan& scan : waiting_) {
            const bool has_part = part == Part::lines ? scan.lines != nullptr : scan.T_odom_base.has_value();
            if (scan.stamp_ns == item.stamp_ns && !has_part) return scan;
        }
    auto place =
        std::lower_bound(waiting_.begin(), waiting_.end(), item.sequence,
                         [](const Scan& s, std::uint64_t sequence) { return s.sequence < sequence; });
    if (place == waiting_.end() || place->sequence != item.sequence) {
        place = waiting_.emplace(place);
        place->sequence = item.sequence;
        place->commanded = commanded_;
    }
    place->stamp_ns = item.stamp_ns;
    place->timestamp = item.observation->timestamp;
    return *place;
}

void LineSlam::take_command(const std::string& text, StampNs stamp_ns) {
    for (const Regime regime : all_regimes)
        if (text == command_words[static_cast<int>(regime)]) commanded_ = Command{regime, stamp_ns};
}

void LineSlam::process(const StreamItem& item, Publisher& publisher) {
    if (status_ != SlamStatus::good) return;
    const auto* of_class = item.observation->GetRuntimeClass();
    if (of_class == CLASS_ID(CObservationLines)) {
        Scan& scan = waiting_scan(item, Part::lines);
        scan.lines = std::static_pointer_cast<const CObservationLines>(item.observation);
        newest_lines_ = scan.sequence;
    } else if (of_class == CLASS_ID(mrpt::obs::CObservationOdometry)) {
        const auto& odometry = static_cast<const mrpt::obs::CObservationOdometry&>(*item.observation);
        if (odometry.sensorLabel != odometry_label) return;
        waiting_scan(item, Part::odometry).T_odom_base =
            Pose2{odometry.odometry.x(), odometry.odometry.y(), wrap_to_pi(odometry.odometry.phi())};
    } else {
        if (const auto* comment = dynamic_cast<const mrpt::obs::CObservationComment*>(item.observation.get()))
            take_command(comment->text, item.stamp_ns);
        return;
    }
    while (!waiting_.empty() && status_ == SlamStatus::good) {
        Scan& first = waiting_.front();
        if (first.T_odom_base && first.lines) {
            estimate(std::move(first), publisher);
        } else if (first.lines || newest_lines_ <= first.sequence) {
            break;
        }  // else: of a laser whose lines nobody extracts, since lines of a later scan have come
        waiting_.pop_front();
    }
}

void LineSlam::drain(Publisher& publisher) {
    for (Scan& scan : waiting_)
        if (status_ == SlamStatus::good && scan.lines) estimate(std::move(scan), publisher);
    waiting_.clear();
    // The last interval may be a short one.
    if (status_ == SlamStatus::good && since_step_) step(*since_step_, publisher);
}

std::vector<LineObservation> LineSlam::observations_in_base(const CObservationLines& lines) const {
    const Pose2 T_base_sensor{lines.sensor_pose.x(), lines.sensor_pose.y(), lines.sensor_pose.yaw()};
    std::vector<LineObservation> observations;
    const SweepTime sweep{scan_duration_s_, lines.scan_beams};
    // All lines of a scan share this noise: so many of them tell no more than one.
    SweepMotion motion = sweep_motion();
    motion.noise_per_s *= static_cast<double>(lines.segments().size());
    for (const lines::LineSegment& segment : lines.segments()) {
        observations.push_back(observation_in_base(segment, T_base_sensor, slam_parameters_.sigma_wall_m));
        if (scan_duration_s_ != 0) deskew(segment, sweep, motion, observations.back());
    }
    return observations;
}

/// As the wheels measured it since the scan before.
SweepMotion LineSlam::sweep_motion() const {
    if (scan_duration_s_ == 0 || !(since_previous_s_ > 0)) return {};
    const ScanPlace &latest = places_.back(), &previous = places_[places_.size() - 2];
    const Pose2 T_previous_base =
        previous.is_step ? latest.T_step_base : previous.T_step_base.inverse() * latest.T_step_base;
    return {log_se2(T_previous_base) * (1 / since_previous_s_),
            interval_->noise_on(T_previous_base, interval_->regime()) / since_previous_s_};
}

ScanMotion LineSlam::motion_until(const Scan& scan) const {
    ScanMotion motion;
    motion.T_odom_base = T_odom_base_;
    motion.duration_s = places_.empty() ? 0 : seconds_between(places_.back().stamp_ns, scan.stamp_ns);
    if (!scan.commanded) return motion;
    motion.commanded = scan.commanded->regime;
    if (motion.duration_s > 0)
        motion.commanded_at = std::clamp(
            seconds_between(places_.back().stamp_ns, scan.commanded->since_ns) / motion.duration_s, 0.0, 1.0);
    return motion;
}

void LineSlam::estimate(Scan&& scan, Publisher& publisher) {
    if (!scan.T_odom_base) ++without_odometry_;
    T_odom_base_ = scan.T_odom_base.value_or(T_odom_base_);
    const ScanMotion motion = motion_until(scan);
    since_previous_s_ = motion.duration_s;
    const bool due = interval_->add(motion);
    places_.push_back({scan.sequence, scan.stamp_ns,
                       interval_->T_step_base_predicted(slam_->filter().calibration()), interval_->regime(),
                       false});
    if (due)
        step(scan, publisher);
    else
        since_step_ = std::move(scan);
}

/// Of the filter, at the latest scan.
void LineSlam::step(const Scan& scan, Publisher& publisher) {
    status_ = slam_->step(interval_->pieces(), observations_in_base(*scan.lines));
    if (calibrates_) drive_.push_back(interval_->drive_pieces());
    interval_->restart();
    since_step_.reset();
    if (status_ != SlamStatus::good) return;
    places_.back().is_step = true;
    steps_.push_back({slam_->filter().T_map_base(), slam_->filter().pose_covariance()});
    const auto published = pose_observation(steps_.back().T_map_base, steps_.back().covariance);
    published->timestamp = scan.timestamp;
    publisher.publish(published, scan.sequence);
}

void LineSlam::calibrate(Results& results) const {
    CalibrationParameters parameters;
    parameters.regimes = interval_parameters_.regimes;
    parameters.smoother = smoother_parameters_;
    parameters.graph.gate = smoother_parameters_.pairing.gate;
    parameters.graph.wall_correlation_m = slam_parameters_.wall_correlation_m;
    const DriveCalibration calibration = calibrate_drive(slam_->history(), drive_, parameters);
    if (!calibration.good) {
        results.refused =
            "line_slam: this log can't be calibrated from; it takes a drive along walls that are seen again "
            "and again";
        return;
    }
    results.calibrations.push_back(
        calibration_section(calibration, {slam_parameters_.drive, interval_parameters_.regimes,
                                          interval_parameters_.control, commanded_.has_value()}));
    results.metrics["calibration_rounds"] = static_cast<std::int64_t>(calibration.rounds);
}

void LineSlam::finish(Results& results) {
    lay_out_trajectory();
    const LineSlamCounts& counts = slam_->counts();
    auto& metrics = results.metrics;
    metrics["predictions"] = counts.predictions;
    metrics["updates"] = counts.updates;
    metrics["re_predictions"] = static_cast<std::int64_t>(interval_->re_predictions());
    metrics["associations"] = counts.associations;
    metrics["rejected"] = counts.rejected;
    metrics["loops_found"] = counts.recognised;
    metrics["loops_refused"] = counts.refused;
    metrics["wheel_slips"] = counts.slips;
    metrics["lines_merged"] = counts.merged;
    metrics["lines_dropped"] = counts.dropped;
    if (without_odometry_) metrics["scans_without_odometry"] = without_odometry_;
    if (status_ != SlamStatus::good) {
        results.refused = "line_slam: the estimate diverged after " + std::to_string(places_.size()) +
                          " scans; check the units of the odometry and the noise given in [line_slam]";
        return;
    }
    if (calibrates_) calibrate(results);

    LineMap map;
    if (smoothing_) {
        const SmoothedPath smoothed = smooth(slam_->history(), smoother_parameters_);
        if (smoothed.good) {
            revise_trajectory(smoothed);
            for (const SmoothedWall& w : smoothed.walls)
                map.push_back(
                    map_line(w.wall.line, w.covariance, w.wall.extent, w.wall.observations, map.size()));
            metrics["smoothing_iterations"] = static_cast<std::int64_t>(smoothed.iterations);
        }
    }
    if (map.empty()) {
        const Ekf& filter = slam_->filter();
        const std::vector<Eigen::Matrix2d> covariances = filter.line_covariances();
        for (int id = 0; id < filter.line_ids(); ++id) {
            if (!filter.exists(id)) continue;
            const auto i = static_cast<std::size_t>(id);
            const MapLineRecord& record = slam_->records()[i];
            map.push_back(
                map_line(filter.line(id), covariances[i], record.extent, record.observations, map.size()));
        }
    }
    metrics["lines_in_map"] = static_cast<std::int64_t>(map.size());
    results.line_map = std::move(map);
}

}  // namespace loopline
