#include "landmark_odometry/landmark_odometry_module.h"

#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <algorithm>
#include <cmath>

#include "api/observation_class.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LandmarkOdometryModule, Module, loopline)

using namespace landmark_odometry;

ModuleInfo LandmarkOdometryModule::info() const {
    return {"landmark_odometry",
            "Motion by landmarks that are points, such as trunks, poles or reflectors, seen by range and "
            "bearing, with wheels from scan to scan.",
            {"CObservationBearingRange", "CObservationOdometry"},
            {},
            {"CObservationRobotPose"}};
}

ParameterTable LandmarkOdometryModule::parameters() {
    auto& s = settings_;
    return ParameterTable("landmark_odometry", info().sentence)
        .text("sensor_label", sensor_label_,
              "Sensor whose landmarks are used; empty for the one that comes first in the log, others are "
              "ignored.")
        .text("odometry", odometry_label_,
              "Label of the wheel odometry that leads from scan to scan, CObservationOdometry, such as that "
              "of the log or calibrated_wheels; empty for the one that comes first.")
        .real("sigma_range_m", sightings_.sigma_range_m, {1e-3, 10},
              "Standard deviation of a landmark's range, its own width included.")
        .angle("sigma_bearing_deg", sightings_.sigma_bearing_rad, {1e-3, 45}, "The same of its bearing.")
        .real("max_range_m", sightings_.max_range_m, {1, 1000}, "What is seen farther away is left out.")
        .real("gate", s.gate, {0.5, 0.999999},
              "Part of good sightings that are to pass: what is farther off a landmark than they are is not "
              "that one.")
        .real("new_beyond_m", s.new_beyond_m, {0, 100},
              "What is seen nearer than this to a landmark, and is not that one, is no new one either.")
        .integer("sightings_of_new", s.sightings_of_new, {1, 100},
                 "A landmark is what was seen at one place in so many scans.")
        .real("remember_m", s.remember_m, {0.1, 1e6},
              "A landmark that was not seen on so much way is forgotten.")
        .real("noise_along_m", s.motion.along_m, {0, 10},
              "Noise of the wheels' way after 1 m; it grows with the root of the way.")
        .real("noise_across_m", s.motion.across_m, {0, 10}, "The same to the side.")
        .angle("noise_heading_deg", s.motion.heading_rad, {0, 180}, "The same of the heading after 1 m.")
        .angle("noise_turn_deg", s.motion.heading_per_turn_rad, {0, 360},
               "And after one full turn, beside it.")
        .real("up_m", s.up_m, {0, 10}, "What the road rises by after 1 m, which no landmark tells.")
        .angle("tilt_deg", s.tilt_rad, {0, 45}, "And what its slope changes by after 1 m.");
}

std::string LandmarkOdometryModule::check() const {
    if (odometry_label_ == published_label)
        return "odometry = landmark_odometry would lead it by itself; name the wheels of the log";
    return {};
}

void LandmarkOdometryModule::start(const RunContext& context) {
    odometry_ = std::make_unique<LandmarkOdometry>(settings_);
    placed_.keep_in(context.scratch_folder, "landmark_odometry");
}

void LandmarkOdometryModule::process(const StreamItem& item, Publisher& publisher) {
    const auto* observation = item.observation.get();
    if (const auto* landmarks = as<mrpt::obs::CObservationBearingRange>(observation))
        take_landmarks(item, *landmarks);
    else
        take_wheels(*observation, item.stamp_ns);
    while (!waiting_.empty() && wheels_.reaches(waiting_.front().stamp_ns)) {
        place(waiting_.front(), publisher);
        waiting_.pop_front();
    }
}

void LandmarkOdometryModule::take_landmarks(const StreamItem& item,
                                            const mrpt::obs::CObservationBearingRange& observation) {
    const std::string& label = observation.sensorLabel;
    if (scans_ == 0 && (sensor_label_.empty() || label == sensor_label_)) label_in_use_ = label;
    if (label != label_in_use_ || (!sensor_label_.empty() && label != sensor_label_)) {
        ++other_sensors_;
        return;
    }
    ++scans_;
    const StampNs latest_ns = waiting_.empty() ? last_ns_ : waiting_.back().stamp_ns;
    if (item.stamp_ns <= latest_ns) {
        ++backwards_;
        return;
    }
    waiting_.push_back(
        {item.sequence, item.stamp_ns, observation.timestamp, sightings_of(observation, sightings_)});
}

void LandmarkOdometryModule::take_wheels(const mrpt::obs::CObservation& observation, StampNs stamp_ns) {
    const auto* wheels = as<mrpt::obs::CObservationOdometry>(&observation);
    if (wheels == nullptr || (!odometry_label_.empty() && wheels->sensorLabel != odometry_label_)) return;
    if (wheel_poses_ == 0) wheels_in_use_ = wheels->sensorLabel;
    const auto& p = wheels->odometry;
    const bool finite = std::isfinite(p.x()) && std::isfinite(p.y()) && std::isfinite(p.phi());
    if (wheels->sensorLabel != wheels_in_use_ || !finite) return;
    wheel_poses_ += wheels_.take(stamp_ns, {p.x(), p.y(), wrap_to_pi(p.phi())}) ? 1 : 0;
}

void LandmarkOdometryModule::place(const Scan& scan, Publisher& publisher) {
    const auto told = placed_.empty() ? wheels_.motion(scan.stamp_ns, scan.stamp_ns)
                                      : wheels_.motion(last_ns_, scan.stamp_ns);
    if (!told) {
        ++before_wheels_;
        return;
    }
    odometry_->take(*told, scan.sightings);
    last_ns_ = scan.stamp_ns;
    wheels_.forget_before(last_ns_);
    const PoseWithCovariance pose = odometry_->pose();
    Placed placed;
    placed.sequence = scan.sequence;
    placed.stamp_ns = scan.stamp_ns;
    placed.T_map_base = Pose3Record(pose.T_map_base);
    Eigen::Map<Matrix6d>(placed.covariance.data()) = pose.covariance;
    placed_.push_back(placed);
    publisher.publish(pose_observation(published_label, scan.timestamp, pose.T_map_base, pose.covariance),
                      scan.sequence);
}

void LandmarkOdometryModule::finish(Results& results) {
    if (placed_.empty())
        results.refused = scans_ == 0
                              ? "the log has no landmarks by range and bearing, which module "
                                "landmark_odometry is for; see `loopline check` for what it has, and "
                                "[landmark_odometry] sensor_label"
                              : "no landmarks of the log have wheel odometry before and after them, by which "
                                "module landmark_odometry knows its way; see [landmark_odometry] odometry";
    for (const Placed placed : placed_)
        trajectory_.append(placed.sequence, placed.stamp_ns, placed.T_map_base.pose(),
                           Matrix6d(Eigen::Map<const Matrix6d>(placed.covariance.data())));
    const SightingCounts& counts = odometry_->counts();
    auto& metrics = results.metrics;
    metrics["landmark_sightings_matched"] = counts.matched;
    metrics["landmark_sightings_ambiguous"] = counts.ambiguous;
    metrics["landmark_sightings_off"] = counts.off;
    metrics["landmark_sightings_tentative"] = counts.tentative;
    metrics["landmarks"] = counts.landmarks;
    if (counts.matched > 0)
        metrics["landmark_mean_square"] = counts.sum_of_squares / (2 * static_cast<double>(counts.matched));
    if (before_wheels_ > 0) metrics["landmark_scans_before_wheels"] = before_wheels_;
    if (!waiting_.empty())
        metrics["landmark_scans_after_wheels"] = static_cast<std::int64_t>(waiting_.size());
    if (backwards_ > 0) metrics["landmark_scans_backwards"] = backwards_;
    if (other_sensors_ > 0) metrics["landmark_other_sensors"] = other_sensors_;
}

}  // namespace loopline
