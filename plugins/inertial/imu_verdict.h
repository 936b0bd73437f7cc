/// What is wrong with an IMU of a log, in words with numbers, and what to do about it.
#pragma once

#include <string>
#include <vector>

#include "inertial/imu_check.h"

namespace loopline::inertial {

/// Clauses that go on after the sensor's name. Times are counted from `log_start_ns`; `label` is what the
/// .ini calls the sensor.
std::vector<std::string> imu_complaints(const ImuCheck& check, const std::string& label,
                                        StampNs log_start_ns);

/// Its parts: stamps and rate; channels that do not change; unit and size of gravity; gyro against odometry;
/// which axis is up.
std::vector<std::string> stamp_complaints(const ImuCheck& check, StampNs log_start_ns);
std::vector<std::string> stuck_complaints(const ImuCheck& check, StampNs log_start_ns);
std::vector<std::string> gravity_complaints(const ImuCheck& check);
std::vector<std::string> turning_complaints(const ImuCheck& check, const Agreement& agreement);
std::vector<std::string> mounting_complaints(const ImuCheck& check, const Agreement& agreement,
                                             const std::string& label);

/// How the log, or [mount], has the IMU turned on the vehicle, a clause as above; empty if it stands upright, or if
/// gravity does not agree, of which mounting_complaints() tells.
std::string mounting_remark(const ImuCheck& check);

/// Whether gyro and odometry were compared while the vehicle turned, and agree about an axis and a sign.
bool turned_enough(const Agreement& agreement);
bool agrees(const Agreement& agreement);

}  // namespace loopline::inertial
