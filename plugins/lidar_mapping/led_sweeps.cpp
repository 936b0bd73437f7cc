#include "lidar_mapping/led_sweeps.h"

#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cmath>

#include "api/observation_class.h"

namespace loopline::lidar_mapping {
namespace {

bool is_pose(const mrpt::obs::CObservation& observation) {
    return as<mrpt::obs::CObservationRobotPose>(&observation) != nullptr ||
           as<mrpt::obs::CObservationOdometry>(&observation) != nullptr;
}

}  // namespace

void LedSweepsSettings::declare_sensors(ParameterTable& table) {
    table.list("sensors", sensors, "Labels of the lidars whose sweeps are used; empty for all.");
}

void LedSweepsSettings::declare_odometry(ParameterTable& table) {
    table
        .text("odometry", odometry.label,
              "Label of the odometry that predicts each sweep's pose, such as lidar_odometry; empty: the "
              "velocity goes on as it was.")
        .real("odometry_sigma_m", odometry.sigma_m, {1e-4, 100},
              "Standard deviation of the odometry's way between two sweeps, beside what it says itself.")
        .angle("odometry_sigma_deg", odometry.sigma_rad, {1e-3, 180}, "And of the turn.")
        .real("odometry_sigma_scale", odometry.sigma_scale, {0, 1},
              "Standard deviation of its scale, a part of the way: where sweeps do not tell how far the "
              "vehicle "
              "has come, as along a tunnel, it adds up.");
}

void LedSweepsSettings::declare_cloud_sweep(ParameterTable& table) {
    table.real("cloud_sweep_s", cloud_sweep.sweep_s, {0, 10},
               "Duration of a sweep whose points come without times.");
}

void LedSweepsSettings::use(ModuleInfo& info) const {
    if (odometry.label.empty()) return;
    for (const char* pose : {"CObservationRobotPose", "CObservationOdometry"}) info.uses.emplace_back(pose);
}

StampNs LedSweeps::Sweep::middle_ns() const {
    return scan.stamp_ns + std::llround(1e9 * middle_s());
}

void LedSweeps::take(const StreamItem& item, const Follow& follow) {
    if (odometry_.take(*item.observation)) {
        if (waits_ && odometry_.reaches(now_.stamp_ns)) drain(follow);
        return;
    }
    if (is_pose(*item.observation)) return;
    const std::string& label = item.observation->sensorLabel;
    if (!sensors_.empty() && std::find(sensors_.begin(), sensors_.end(), label) == sensors_.end()) return;
    drain(follow);  // the pose of the one before has not come
    if (!reader_.read(*item.observation, now_.scan)) {
        ++unusable_;
        return;
    }
    now_.sequence = item.sequence;
    now_.stamp_ns = item.stamp_ns;
    now_.timestamp = item.observation->timestamp;
    waits_ = true;
    if (!odometry_.wanted() || odometry_.reaches(now_.stamp_ns)) drain(follow);
}

void LedSweeps::drain(const Follow& follow) {
    if (!waits_) return;
    waits_ = false;
    follow(now_);
}

}  // namespace loopline::lidar_mapping
