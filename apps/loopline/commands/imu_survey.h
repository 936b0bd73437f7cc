/// The IMUs of a log, each checked by itself and against the odometry.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "api/module.h"
#include "inertial/imu_check.h"

namespace loopline {

class ImuSurvey {
 public:
    void add(const StreamItem& item);

    /// Whether the label is that of an IMU whose stamps are looked at here.
    bool looks_at(const std::string& label) const;
    bool looks_at(const mrpt::obs::CObservation& observation) const;
    /// A sentence for each thing that is likely to spoil inertial navigation. An IMU that gives no rates and
    /// no accelerations at all is an inclinometer or a compass, and nothing is said of it.
    std::vector<std::string> complaints(StampNs log_start_ns) const;

    /// And what is known of them beside that.
    std::vector<std::string> remarks() const;

 private:
    std::map<std::string, inertial::ImuCheck> checks_;  ///< by sensor label
    std::optional<std::string> odometry_label_;         ///< of the first odometry: the one to compare with
};

}  // namespace loopline
