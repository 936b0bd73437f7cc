#include "simulation/laser_sensors.h"

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>

#include "simulation/sensor_pose.h"

namespace loopline::simulation {
ParameterTable LaserSensor::declared(const std::string& sentence) {
    return ParameterTable(name(), sentence)
        .integer("beams", laser_.beams, {2, 20000}, "Beams of a scan.")
        .angle("field_of_view_deg", laser_.field_of_view_rad, {1, 360}, "From the first beam to the last.")
        .real("rate_hz", laser_.rate_hz, {0.1, 1000}, "Scans a second.")
        .real("sweep_part", laser_.sweep_part, {0, 1},
              "Part of the time from scan to scan within which the beams are measured, one after the other.")
        .real("min_range_m", laser_.min_range_m, Range::at_least(0), "What is nearer gives no return.")
        .real("max_range_m", laser_.max_range_m, Range::positive(), "What is farther gives no return.")
        .real("sigma_range_m", laser_.sigma_range_m, {0, 10}, "Standard deviation of a range.")
        .real("resolution_m", laser_.resolution_m, {0, 10}, "Ranges are multiples of this; 0: any number.")
        .real("dropouts", laser_.dropouts, {0, 1},
              "Part of the beams that give no return, wherever they point.")
        .angle("beam_width_deg", laser_.beam_width_rad, {0, 10},
               "Divergence of a beam; 0: no beam meets an edge.")
        .real("mixed_pixels", laser_.mixed_pixels, {0, 1},
              "Part of the beams on an edge whose range lies somewhere between the two surfaces.")
        .real("mixed_gap_m", laser_.mixed_gap_m, Range::at_least(0),
              "Where the surfaces are farther apart, the nearer one counts instead.")
        .real("x_m", x_m_, {-100, 100}, "Place on the vehicle, forward of the middle of its axle.")
        .real("y_m", y_m_, {-100, 100}, "To the left.")
        .real("z_m", z_m_, {0, 100}, "Above ground.")
        .angle("yaw_deg", yaw_rad_, {-180, 180}, "Its heading on the vehicle.");
}

std::string LaserSensor::check() const {
    if (laser_.min_range_m >= laser_.max_range_m) return "min_range_m is not below max_range_m";
    return {};
}

Pose3 LaserSensor::mount() const {
    return {{x_m_, y_m_, z_m_}, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad_, Eigen::Vector3d::UnitZ()))};
}

void LaserSensor::start(const Scene& scene) {
    scene_ = &scene;
    model_.emplace(laser_, RandomStream(scene.seed, name()));
    index_ = returns_ = 0;
}

mrpt::obs::CObservation::Ptr LaserSensor::next() {
    const StampNs time_ns = next_time_ns();
    const auto T_map_sensor = [this](StampNs at_ns) {
        return scene_->drive.motion.pose_at(at_ns) * T_base_sensor(at_ns);
    };
    CylindersAt cylinders_at;
    if (!scene_->walkers.empty())
        cylinders_at = [this](StampNs at_ns) { return scene_->cylinders_at(at_ns); };
    const std::vector<Beam>& beams = model_->scan(time_ns, T_map_sensor, *scene_->caster, cylinders_at);

    auto observation = mrpt::obs::CObservation2DRangeScan::Create();
    observation->sensorLabel = name();
    observation->timestamp = stamp_to_mrpt(scene_->start_ns + time_ns);
    observation->aperture = static_cast<float>(laser_.field_of_view_rad);
    observation->rightToLeft = true;
    observation->maxRange = static_cast<float>(laser_.max_range_m);
    observation->stdError = static_cast<float>(laser_.sigma_range_m);
    observation->beamAperture = static_cast<float>(laser_.beam_width_rad);
    observation->sensorPose = mrpt_pose(T_base_sensor(time_ns));
    observation->resizeScan(beams.size());
    for (std::size_t i = 0; i < beams.size(); ++i) {
        observation->setScanRange(i, static_cast<float>(beams[i].range_m));
        observation->setScanRangeValidity(i, beams[i].valid);
        returns_ += beams[i].valid;
    }
    ++index_;
    return observation;
}

std::string LaserSensor::summary() const {
    return name() + ": " + std::to_string(returns_) + " returns in " + std::to_string(index_) + " scans.";
}

SurveyLaser::SurveyLaser() {
    laser_.rate_hz = 15.6;
    x_m_ = 0;
    z_m_ = 1.2;
}

ParameterTable SurveyLaser::parameters() {
    return declared(
               "A laser that a servo tilts up and down, about the left axis of its mount: "
               "CObservation2DRangeScan, "
               "with the sensorPose of each scan's first beam.")
        .angle("lowest_deg", servo_.lowest_rad, {-90, 90}, "Where a sweep up starts; negative looks down.")
        .angle("highest_deg", servo_.highest_rad, {-90, 90}, "Where it ends.")
        .real("sweep_s", servo_.sweep_s, {0.1, 10000}, "Time from one end to the other.")
        .real("arm_m", arm_m_, {0, 10}, "From the servo's axis, where the mount is, forward to the sensor.");
}

std::string SurveyLaser::check() const {
    if (servo_.lowest_rad >= servo_.highest_rad) return "lowest_deg is not below highest_deg";
    return LaserSensor::check();
}

Pose3 SurveyLaser::T_base_sensor(StampNs time_ns) const {
    return mount() * T_mount_servo(servo_elevation_rad(servo_, time_ns)) *
           Pose3({arm_m_, 0, 0}, Eigen::Quaterniond::Identity());
}

mrpt::obs::CObservation::Ptr SurveyLaser::next() {
    last_ns_ = next_time_ns();
    const auto sweep_ns = static_cast<StampNs>(std::llround(1e9 * laser_.sweep_part / laser_.rate_hz));
    auto observation = LaserSensor::next();
    static_cast<mrpt::obs::CObservation2DRangeScan&>(*observation).deltaPitch =
        servo_elevation_rad(servo_, last_ns_) - servo_elevation_rad(servo_, last_ns_ + sweep_ns);
    return observation;
}

std::string SurveyLaser::summary() const {
    const double sweeps = seconds_between(0, last_ns_) / servo_.sweep_s;
    return LaserSensor::summary() + " " + std::to_string(std::llround(sweeps)) + " sweeps up or down.";
}

}  // namespace loopline::simulation
