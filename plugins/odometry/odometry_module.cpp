#include "odometry/odometry_module.h"

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "api/observation_class.h"
#include "api/sweep_classes.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(Odometry, Module, loopline)

namespace {

bool is_sweep(const mrpt::obs::CObservation& observation) {
    const std::string_view name = observation.GetRuntimeClass()->className;
    const auto& classes = sweep_classes();
    return std::find(classes.begin(), classes.end(), name.substr(name.rfind(':') + 1)) != classes.end();
}

bool is_finite(const mrpt::poses::CPose2D& pose) {
    return std::isfinite(pose.x()) && std::isfinite(pose.y()) && std::isfinite(pose.phi());
}

}  // namespace

ModuleInfo Odometry::info() const {
    ModuleInfo info{"odometry",
                    "Dead reckoning from wheel odometry, interpolated to the stamp of every 2D scan.",
                    {"CObservationOdometry", "CObservation2DRangeScan"},
                    {},
                    {"CObservationOdometry"}};
    if (sweeps_) {
        info.uses = sweep_classes();
        info.uses.insert(info.uses.begin(), "CObservation2DRangeScan");
        info.needs.pop_back();
    }
    return info;
}

ParameterTable Odometry::parameters() {
    return ParameterTable("odometry", info().sentence)
        .choice("source", source_, {{"pose", Source::pose}, {"ticks", Source::ticks}},
                "Take the cumulative pose of the observations, or integrate their encoder ticks.")
        .text("sensor_label", sensor_label_,
              "Odometry sensor to use; empty for the one that comes first in the log, others are ignored.")
        .list("scans", scan_labels_,
              "Labels of the lasers and spinning lidars whose scans get a dead-reckoned pose; empty for all.")
        .boolean("sweeps", sweeps_,
                 "Sweeps of spinning lidars get one, too, labelled odometry_at_sweep, and scans need not be "
                 "there.")
        .real("metres_per_tick_left_m", drive_.metres_per_tick_left_m, Range::at_least(0),
              "Way of the left wheel for one encoder tick; needed with source = ticks.")
        .real("metres_per_tick_right_m", drive_.metres_per_tick_right_m, Range::at_least(0),
              "Way of the right wheel for one encoder tick; needed with source = ticks.")
        .real("track_width_m", drive_.track_width_m, Range::at_least(0),
              "Distance of the two wheels; needed with source = ticks.")
        .real("noise_along_m", noise_.along_m, Range::at_least(0),
              "Standard deviation along the path after one metre; variances grow in proportion to the way.")
        .real("noise_across_m", noise_.across_m, Range::at_least(0),
              "Standard deviation across the path after one metre, beside what the heading brings.")
        .angle("noise_heading_deg", noise_.heading_rad, {0, 180},
               "Standard deviation of the heading after one metre.")
        .angle("noise_turn_deg", noise_.heading_per_turn_rad, {0, 360},
               "Standard deviation of the heading after one full turn.")
        .real("max_delay_s", synchronisation_.max_delay_s, Range::at_least(0),
              "How far a scan may stand in the log from the odometry of its own time; beyond, its neighbour "
              "in the log is used.")
        .real("max_extrapolation_s", synchronisation_.max_extrapolation_s, Range::at_least(0),
              "At the log's end, motion is continued beyond the last odometry for at most this long.");
}

std::string Odometry::check() const {
    const bool calibrated =
        drive_.metres_per_tick_left_m > 0 && drive_.metres_per_tick_right_m > 0 && drive_.track_width_m > 0;
    if (source_ == Source::ticks && !calibrated)
        return "source = ticks needs metres_per_tick_left_m, metres_per_tick_right_m and track_width_m above "
               "0";
    return {};
}

void Odometry::start(const RunContext& context) {
    path_.keep_in(context.scratch_folder, "odometry");
    trajectory_.keep_in(context.scratch_folder);
    at_scans_ = OdometryAtScans(synchronisation_);
}

void Odometry::process(const StreamItem& item, Publisher& publisher) {
    const auto* observation = item.observation.get();
    if (const auto* odometry = as<mrpt::obs::CObservationOdometry>(observation)) {
        take_odometry(*odometry, item.stamp_ns);
    } else {
        const bool scan = as<mrpt::obs::CObservation2DRangeScan>(observation),
                   sweep = !scan && is_sweep(*observation);
        if (!scan && !sweep) return;
        if (!scan_labels_.empty() && std::find(scan_labels_.begin(), scan_labels_.end(),
                                               observation->sensorLabel) == scan_labels_.end())
            return;
        at_scans_.add_scan(item.sequence, item.stamp_ns);
        waiting_.push_back({item.sequence, item.stamp_ns, observation->timestamp, sweep});
        ++scans_;
    }
    while (const auto placed = at_scans_.next()) publish(*placed, publisher);
}

void Odometry::drain(Publisher& publisher) {
    while (const auto placed = at_scans_.next_at_end()) publish(*placed, publisher);
}

void Odometry::take_odometry(const mrpt::obs::CObservationOdometry& observation, StampNs stamp_ns) {
    // What an earlier run recorded is no second sensor, unless it is asked for.
    const bool own =
        (observation.sensorLabel == published_label || observation.sensorLabel == label_at_sweep) &&
        sensor_label_ != observation.sensorLabel;
    if (!own && !label_in_use_ && (sensor_label_.empty() || sensor_label_ == observation.sensorLabel))
        label_in_use_ = observation.sensorLabel;
    if (own || label_in_use_ != observation.sensorLabel) {
        ++ignored_;
        return;
    }

    OdometrySample sample;
    sample.stamp_ns = stamp_ns;
    if (observation.hasEncodersInfo)
        sample.ticks = unwrap_ticks_(observation.encoderLeftTicks, observation.encoderRightTicks);
    if (source_ == Source::pose) {
        if (!is_finite(observation.odometry)) {
            ++not_finite_;
            return;
        }
        sample.T_odom_base = {observation.odometry.x(), observation.odometry.y(),
                              wrap_to_pi(observation.odometry.phi())};
    } else {
        if (!sample.ticks) {
            ++without_ticks_;
            return;
        }
        if (last_ticks_)
            T_odom_base_of_ticks_ =
                T_odom_base_of_ticks_ * exp_se2(motion_from_ticks(drive_, *last_ticks_, *sample.ticks));
        last_ticks_ = sample.ticks;
        sample.T_odom_base = T_odom_base_of_ticks_;
    }
    at_scans_.add_odometry(sample);
    ++samples_;
}

void Odometry::publish(const PlacedScan& placed, Publisher& publisher) {
    const ScanStamp stamp = waiting_.front();
    waiting_.pop_front();
    by_file_order_ += placed.by == PlacedScan::By::file_order;
    extrapolated_ += placed.by == PlacedScan::By::extrapolation;

    path_.push_back({placed.scan, stamp.stamp_ns, placed.T_odom_base});

    const auto observation = pool_.take();
    observation->sensorLabel = stamp.is_sweep ? label_at_sweep : published_label;
    observation->timestamp = stamp.timestamp;
    observation->odometry = {placed.T_odom_base.x_m, placed.T_odom_base.y_m, placed.T_odom_base.phi_rad};
    observation->hasEncodersInfo = placed.ticks.has_value();
    if (placed.ticks) {
        observation->encoderLeftTicks =
            static_cast<std::int32_t>(static_cast<std::uint32_t>(placed.ticks->left));
        observation->encoderRightTicks =
            static_cast<std::int32_t>(static_cast<std::uint32_t>(placed.ticks->right));
    }
    observation->hasVelocities = placed.velocity.has_value();
    if (placed.velocity) {
        observation->velocityLocal = {placed.velocity->forward_m, placed.velocity->left_m,
                                      placed.velocity->turn_rad};
    }
    publisher.publish(observation, placed.scan);
}

void Odometry::lay_out_trajectory() {
    if (path_.empty()) return;
    const PreparedPose2 T_map_odom(path_.front().T_odom_base.inverse());
    Pose2 T_map_previous;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const DeadReckoned& scan : path_) {
        const Pose2 T_map_base = T_map_odom * scan.T_odom_base;
        if (!trajectory_.empty())
            covariance = propagate_covariance(covariance, T_map_previous, T_map_base, noise_);
        T_map_previous = T_map_base;
        trajectory_.append(scan.sequence, scan.stamp_ns, Pose3(T_map_base),
                           PoseCovariance::planar(covariance));
    }
}

void Odometry::finish(Results& results) {
    lay_out_trajectory();
    results.metrics["odometry_samples"] = samples_;
    if (ignored_) results.metrics["odometry_ignored"] = ignored_;
    if (not_finite_) results.metrics["odometry_not_finite"] = not_finite_;
    if (by_file_order_) results.metrics["odometry_scans_by_file_order"] = by_file_order_;
    if (extrapolated_) results.metrics["odometry_scans_extrapolated"] = extrapolated_;
    if (!waiting_.empty())
        results.metrics["odometry_scans_without"] = static_cast<std::int64_t>(waiting_.size());
    if (scans_ > 0 && samples_ == 0 && without_ticks_ > 0)
        results.refused =
            "odometry: source = ticks, but no odometry observation of the log carries encoder ticks; use "
            "source = pose";
}

}  // namespace loopline
