/// A servo that tilts a sensor up and down at constant speed.
#pragma once

#include <cmath>

#include "api/pose3.h"
#include "api/stamp.h"

namespace loopline::simulation {

struct ServoSettings {
    double lowest_rad = -30 * M_PI / 180;  ///< elevation: positive looks up
    double highest_rad = 60 * M_PI / 180;
    double sweep_s = 22.3;  ///< from one end to the other
};

/// Starts at its lowest; one sweep up, one sweep down.
inline double servo_elevation_rad(const ServoSettings& servo, StampNs time_ns) {
    const double sweeps = seconds_between(0, time_ns) / servo.sweep_s;
    const double part = 1 - std::abs(1 - 2 * (sweeps / 2 - std::floor(sweeps / 2)));
    return servo.lowest_rad + part * (servo.highest_rad - servo.lowest_rad);
}

/// The turned frame in that of the servo's mount: about y, where MRPT's pitch is positive downwards.
inline Pose3 T_mount_servo(double elevation_rad) {
    return {Eigen::Vector3d::Zero(),
            Eigen::Quaterniond(Eigen::AngleAxisd(-elevation_rad, Eigen::Vector3d::UnitY()))};
}

}  // namespace loopline::simulation
