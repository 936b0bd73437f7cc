#include "line_slam/line_slam_module.h"

#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cmath>

#include "line_slam/line_input.h"
#include "lines/observation_lines.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LineSlam, Module, loopline)

namespace {

using namespace line_slam;

Matrix6d spatial_covariance(const Eigen::Matrix3d& planar) {
    constexpr int index[3] = {0, 1, 5};  // x, y, yaw of (x y z roll pitch yaw)
    Matrix6d covariance = Matrix6d::Zero();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            covariance(index[row], index[column]) = planar(row, column);
    return covariance;
}

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
            {},
            {"CObservationRobotPose"}};
}

ParameterTable LineSlam::parameters() {
    auto& drive = slam_parameters_.drive;
    return ParameterTable("line_slam", info().sentence)
        .real("track_width_m", drive.track_width_m, Range::positive(), "Distance of the driven wheels.")
        .real("sigma_wheel_m", drive.sigma_wheel_m, {0, 10},
              "Standard deviation of one wheel's travel after 1 m; variances grow in proportion to the way.")
        .real("sigma_side_m", drive.sigma_side_m, {0, 10},
              "Standard deviation of sideways motion after 1 m of travel.")
        .real("sigma_rest_m", drive.sigma_rest_m, {1e-6, 1},
              "Standard deviation of each of these between two scans without any motion.")
        .real(
            "sigma_scale", drive.sigma_scale, {1e-6, 1},
            "How well wheel diameters and track width are known, as a fraction; their errors are estimated.")
        .real("sigma_wall_m", slam_parameters_.sigma_wall_m, {0, 1},
              "How far the ends of a wall lie off a straight line.")
        .real("gate_probability", gate_probability_, {0.5, 0.999999},
              "Share of true pairings that the association gate lets pass.")
        .real("max_gap_m", slam_parameters_.association.max_gap_m, {0, 100},
              "Gap between the seen part of a map line and an observation, up to which it can be the same "
              "wall.")
        .integer("support_scans", slam_parameters_.tentative.scans, {1, 1000},
                 "Scans that must have seen a line before it enters the state.")
        .boolean("smoothing", smoothing_, "Smooth the whole path at the end of the log.");
}

void LineSlam::start(const RunContext&) {
    const double gate =
        -2 * std::log(1 - gate_probability_);  // quantile of chi-square, two degrees of freedom
    slam_parameters_.association.gate = gate;
    slam_parameters_.tentative.gate = gate;
    slam_parameters_.tentative.max_gap_m = slam_parameters_.association.max_gap_m;
    smoother_parameters_.pairing.gate = gate;
    smoother_parameters_.pairing.max_gap_m = slam_parameters_.association.max_gap_m;
    smoother_parameters_.min_observations = slam_parameters_.tentative.scans;
    slam_ = std::make_unique<LineEkfSlam>(slam_parameters_);
}

void LineSlam::process(const StreamItem& item, Publisher& publisher) {
    if (status_ != SlamStatus::good) return;
    const auto* observation = item.observation.get();
    if (const auto* lines = dynamic_cast<const CObservationLines*>(observation)) {
        auto& [sequence, scan] = scan_of(item, Part::lines);
        take_lines(*lines, scan);
        newest_lines_ = sequence;
    } else if (const auto* odometry = dynamic_cast<const mrpt::obs::CObservationOdometry*>(observation);
               odometry && odometry->sensorLabel == odometry_label) {
        scan_of(item, Part::odometry).second.T_odom_base =
            Pose2{odometry->odometry.x(), odometry->odometry.y(), wrap_to_pi(odometry->odometry.phi())};
    } else {
        newest_item_ = std::max(item.sequence, newest_item_.value_or(0));
        return;
    }
    // A scan without lines is known to be one when lines of a later scan have come.
    while (!waiting_.empty() && status_ == SlamStatus::good) {
        const auto first = waiting_.begin();
        if (!first->second.T_odom_base || (!first->second.lines && newest_lines_ <= first->first)) break;
        estimate(first->first, first->second, publisher);
        waiting_.erase(first);
    }
}

std::pair<const std::uint64_t, LineSlam::Scan>& LineSlam::scan_of(const StreamItem& item, Part part) {
    // What a module publishes carries the sequence of a scan that has gone by; what a log holds has its own.
    const bool recorded = !newest_item_ || item.sequence > *newest_item_;
    newest_item_ = std::max(item.sequence, newest_item_.value_or(0));
    if (recorded)
        for (auto& waiting : waiting_) {
            const Scan& scan = waiting.second;
            const bool has_part = part == Part::lines ? scan.lines.has_value() : scan.T_odom_base.has_value();
            if (scan.stamp_ns == item.stamp_ns && !has_part) return waiting;
        }
    auto& waiting = *waiting_.try_emplace(item.sequence).first;
    waiting.second.stamp_ns = item.stamp_ns;
    waiting.second.timestamp = item.observation->timestamp;
    return waiting;
}

void LineSlam::drain(Publisher& publisher) {
    for (const auto& [sequence, scan] : waiting_)
        if (status_ == SlamStatus::good) estimate(sequence, scan, publisher);
    waiting_.clear();
}

void LineSlam::take_lines(const CObservationLines& observation, Scan& scan) const {
    const Pose2 T_base_sensor{observation.sensor_pose.x(), observation.sensor_pose.y(),
                              observation.sensor_pose.yaw()};
    scan.lines.emplace();
    for (const lines::LineSegment& segment : observation.segments)
        scan.lines->push_back(observation_in_base(segment, T_base_sensor, slam_parameters_.sigma_wall_m));
}

void LineSlam::estimate(std::uint64_t sequence, const Scan& scan, Publisher& publisher) {
    Pose2 T_previous_base;
    if (!scan.T_odom_base) {
        ++without_odometry_;
    } else {
        if (T_odom_previous_) T_previous_base = T_odom_previous_->inverse() * *scan.T_odom_base;
        T_odom_previous_ = scan.T_odom_base;
    }
    status_ = slam_->step(T_previous_base, scan.lines.value_or(std::vector<LineObservation>{}));
    if (status_ != SlamStatus::good) return;

    const Pose2& T_map_base = slam_->filter().T_map_base();
    const Eigen::Matrix3d covariance = slam_->filter().pose_covariance();
    trajectory_.append(sequence, scan.stamp_ns, Pose3(T_map_base), spatial_covariance(covariance));
    const auto published = pose_observation(T_map_base, covariance);
    published->timestamp = scan.timestamp;
    publisher.publish(published, sequence);
}

void LineSlam::revise_trajectory(const SmoothedPath& smoothed) {
    for (std::size_t k = 0; k < trajectory_.size(); ++k)
        trajectory_.revise(k, Pose3(smoothed.poses[k]), spatial_covariance(smoothed.covariances[k]));
    trajectory_.finish_revision();
}

void LineSlam::finish(Results& results) {
    const LineSlamCounts& counts = slam_->counts();
    auto& metrics = results.metrics;
    metrics["predictions"] = counts.predictions;
    metrics["updates"] = counts.updates;
    metrics["associations"] = counts.associations;
    metrics["rejected"] = counts.rejected;
    metrics["loops_found"] = counts.recognised;
    metrics["loops_refused"] = counts.refused;
    metrics["wheel_slips"] = counts.slips;
    metrics["lines_merged"] = counts.merged;
    metrics["lines_dropped"] = counts.dropped;
    if (without_odometry_) metrics["scans_without_odometry"] = without_odometry_;
    if (status_ != SlamStatus::good) {
        results.refused = "line_slam: the estimate diverged after " + std::to_string(trajectory_.size()) +
                          " scans; check the units of the odometry and the noise given in [line_slam]";
        return;
    }

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
        for (int id = 0; id < filter.line_ids(); ++id) {
            if (!filter.exists(id)) continue;
            const MapLineRecord& record = slam_->records()[static_cast<std::size_t>(id)];
            const Eigen::Matrix2d covariance =
                filter.is_active(id) ? filter.line_covariance(id) : Eigen::Matrix2d(Eigen::Matrix2d::Zero());
            map.push_back(
                map_line(filter.line(id), covariance, record.extent, record.observations, map.size()));
        }
    }
    metrics["lines_in_map"] = static_cast<std::int64_t>(map.size());
    results.line_map = std::move(map);
}

}  // namespace loopline
