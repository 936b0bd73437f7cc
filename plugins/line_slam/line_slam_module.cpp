#include "line_slam/line_slam_module.h"

#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "line_slam/calibration_section.h"
#include "line_slam/chi_square.h"
#include "line_slam/line_input.h"
#include "lines/observation_lines.h"
#include "odometry/twist2.h"

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

constexpr const char* regime_words[regime_count] = {"driving straight", "turning left", "turning right"};
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

ParameterTable LineSlam::parameters() {
    using Kind = IntervalParameters::Kind;
    using Control = IntervalParameters::Control;
    auto& drive = slam_parameters_.drive;
    auto& interval = interval_parameters_;
    ParameterTable table("line_slam", info().sentence);
    table
        .integer(
            "interval_scans", interval.scans, {1, 1000},
            "Scans from one step of the filter to the next, N of Hu 2012; with interval = adaptive: at most.")
        .choice("interval", interval.kind, {{"fixed", Kind::fixed}, {"adaptive", Kind::adaptive}},
                "Every N-th scan, or as soon as the way, the turn or the uncertainty since the last step "
                "asks for it.")
        .real("adaptive_way_m", interval.max_way_m, {0, 100},
              "Way since the last step that asks for the next.")
        .angle("adaptive_turn_deg", interval.max_turn_rad, {0, 180},
               "Turn since the last step that asks for the next.")
        .real("adaptive_sigma_m", interval.max_sigma_m, {0, 100},
              "Standard deviation of the difference of both wheels' travel that asks for the next step.")
        .choice("control", interval.control,
                {{"measured", Control::measured}, {"commanded", Control::commanded}},
                "What the motion is predicted from: the odometry, or the speeds that belong to each regime.")
        .boolean("re_prediction", interval.re_prediction,
                 "Predict in pieces where the wheel speeds change within an interval; without it, the speeds "
                 "at its "
                 "beginning hold for all of it.")
        .choice("feature", slam_parameters_.feature,
                {{"line", Feature::line}, {"foot_point", Feature::foot_point}},
                "How a wall is measured: distance and direction of the line, or the paper's foot point seen "
                "from the "
                "map's origin.")
        .choice("update", slam_parameters_.update,
                {{"joint", Update::joint}, {"paper_sum", Update::paper_sum}},
                "All lines of a scan at once, or the paper's sum of gains that do not know of one another.")
        .choice("association", slam_parameters_.association.method,
                {{"sequential", AssociationMethod::sequential},
                 {"nearest", AssociationMethod::nearest},
                 {"jcbb", AssociationMethod::jcbb}},
                "Lines of a scan are paired with the map each given the longer ones, each by itself (the "
                "paper), or "
                "by joint compatibility branch and bound.")
        .real("track_width_m", drive.track_width_m, Range::positive(), "Distance of the driven wheels.")
        .real(
            "odometry_track_width_m", drive.odometry_track_width_m, {0, 100},
            "Distance of the wheels that the log's odometry was reckoned with, which tells their travel from "
            "its poses; 0: track_width_m.")
        .real("sigma_wheel_m", drive.sigma_wheel_m, {0, 10},
              "Standard deviation of one wheel's travel after 1 m; variances grow in proportion to the way.")
        .real("sigma_side_m", drive.sigma_side_m, {0, 10},
              "Standard deviation of sideways motion after 1 m of travel.")
        .real("sigma_rest_m", drive.sigma_rest_m, {1e-6, 1},
              "Standard deviation of each of these between two steps without any motion.")
        .real(
            "sigma_scale", drive.sigma_scale, {1e-6, 1},
            "How well wheel diameters and track width are known, as a fraction; their errors are estimated.")
        .real("sigma_wall_m", slam_parameters_.sigma_wall_m, {0, 1},
              "How far the ends of a wall lie off a straight line.")
        .real("gate_probability", gate_probability_, {0.5, 0.999999},
              "Share of true pairings that the association gate lets pass.")
        .real("scan_duration_s", scan_duration_s_, {-10, 10},
              "Time from a scan's first beam to its last, the first being the rightmost; negative if the "
              "laser turns "
              "clockwise. What the vehicle moves meanwhile is taken out of the lines; 0 takes a scan as one "
              "instant.")
        .real("max_gap_m", slam_parameters_.association.max_gap_m, {0, 100},
              "Gap between the seen part of a map line and an observation, up to which it can be the same "
              "wall.")
        .integer("support_scans", slam_parameters_.tentative.scans, {1, 1000},
                 "Steps that must have seen a line before it enters the state.")
        .boolean("smoothing", smoothing_, "Smooth the whole path at the end of the log.");
    for (const Regime regime : all_regimes) {
        RegimeParameters& p = interval.regimes[static_cast<std::size_t>(regime)];
        const std::string name = regime_key(regime), way = regime_words[static_cast<int>(regime)];
        table
            .real(name + "_left_mps", p.commanded.left_mps, {-100, 100},
                  "Left wheel's speed " + way + ", for control = commanded.")
            .real(name + "_right_mps", p.commanded.right_mps, {-100, 100},
                  "Right wheel's speed " + way + ", for control = commanded.")
            .real(name + "_slip_left", p.slip_left, {-1, 1},
                  "Part of the left wheel's travel that is lost " + way + ".")
            .real(name + "_slip_right", p.slip_right, {-1, 1},
                  "Part of the right wheel's travel that is lost " + way + ".")
            .real(
                name + "_sigma_left_m", p.sigma_left_m, {0, 10},
                "Standard deviation of the left wheel's travel after 1 m " + way + "; 0 takes sigma_wheel_m.")
            .real(name + "_sigma_right_m", p.sigma_right_m, {0, 10},
                  "Standard deviation of the right wheel's travel after 1 m " + way +
                      "; 0 takes sigma_wheel_m.");
    }
    return table;
}

std::string LineSlam::check() const {
    if (interval_parameters_.control != IntervalParameters::Control::commanded) return {};
    for (const RegimeParameters& r : interval_parameters_.regimes)
        if (r.commanded.left_mps == 0 && r.commanded.right_mps == 0)
            return "control = commanded needs the wheel speeds of all three regimes (straight_left_mps, "
                   "straight_right_mps, turn_left_left_mps, ...)";
    return {};
}

void LineSlam::start(const RunContext& context) {
    calibrates_ = context.calibrates;
    const double gate = chi_square_quantile(2, gate_probability_);
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

/// As it was known at each time: by the filter at its steps, by the wheels since the last step between them.
void LineSlam::lay_out_trajectory() {
    trajectory_.reserve(places_.size());
    PreparedPose2 T_map_step;
    Eigen::Matrix3d step_covariance = Eigen::Matrix3d::Zero();
    std::size_t steps = 0;
    for (const ScanPlace& place : places_) {
        if (place.is_step) {
            T_map_step = PreparedPose2(steps_[steps].T_map_base);
            step_covariance = steps_[steps++].covariance;
            trajectory_.append(place.sequence, place.stamp_ns, Pose3(T_map_step.pose()),
                               PoseCovariance::planar(step_covariance));
            continue;
        }
        // The step's own error turns the way since then about it.
        const Pose2 T_map_base = T_map_step * place.T_step_base;
        Eigen::Matrix3d carried = Eigen::Matrix3d::Identity();
        carried.topRightCorner<2, 1>() =
            turned_left(T_map_base.translation() - T_map_step.pose().translation());
        trajectory_.append(place.sequence, place.stamp_ns, Pose3(T_map_base),
                           PoseCovariance::planar(carried * step_covariance * carried.transpose() +
                                                  noise_since_step(T_map_step.pose(), place)));
    }
}

/// What the wheels' noise adds to (x, y, phi) from a step to a scan after it.
Eigen::Matrix3d LineSlam::noise_since_step(const Pose2& T_map_step, const ScanPlace& place) const {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_map_step.phi_rad).toRotationMatrix();
    return turn * interval_->noise_on(place.T_step_base, place.regime) * turn.transpose();
}

/// Steps take the smoothed poses, scans between them what the wheels say, bent so that it leads from one step
/// to the next.
void LineSlam::revise_trajectory(const SmoothedPath& smoothed) {
    std::size_t step = 0, last = 0;
    for (std::size_t k = 0; k < places_.size(); ++k) {
        if (!places_[k].is_step) continue;
        trajectory_.revise(k, Pose3(smoothed.poses[step]),
                           PoseCovariance::planar(smoothed.covariances[step]));
        if (step > 0) revise_between(last, k);
        last = k;
        ++step;
    }
    trajectory_.finish_revision();
}

void LineSlam::revise_between(std::size_t from, std::size_t to) {
    const auto& entries = trajectory_.entries();
    const PreparedPose2 T_map_from(entries[from].T_map_base.planar());
    const Pose2 T_map_to = entries[to].T_map_base.planar();
    const Twist2 bend = log_se2((T_map_from * places_[to].T_step_base).inverse() * T_map_to);
    const Eigen::Matrix3d noise = noise_since_step(T_map_from.pose(), places_[to]),
                          covariance_from = entries[from].covariance.planar(),
                          covariance_to = entries[to].covariance.planar();
    for (std::size_t k = from + 1; k < to; ++k) {
        const double u = static_cast<double>(k - from) / static_cast<double>(to - from);
        // Between two known poses the wheels' noise is that of a bridge.
        trajectory_.revise(
            k, Pose3(T_map_from * places_[k].T_step_base * exp_se2(bend * u)),
            PoseCovariance::planar((1 - u) * covariance_from + u * covariance_to + u * (1 - u) * noise));
    }
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
