/// What a log holds, sensor by sensor, for a person who is about to run on it: counts, rates, gaps, empty
/// scans, IMUs that can't be right.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "api/module.h"
#include "api/planar_scan.h"
#include "commands/imu_survey.h"

namespace loopline {

/// One sensor: observations of one class under one label.
struct SensorSurvey {
    std::uint64_t count = 0;
    StampNs first_stamp_ns = 0, last_stamp_ns = 0;
    /// From each observation to the next, in the log's order; not of IMUs, of which there are too many: their
    /// own check counts them.
    std::vector<StampNs> steps_ns;
    StampNs longest_gap_ns = 0;
    StampNs longest_gap_start_ns = 0;
    std::uint64_t repeated_stamps = 0;
    std::uint64_t empty_scans = 0;  ///< planar scans without a usable return

    StampNs median_step_ns() const;
};

class LogSurvey {
 public:
    void add(const StreamItem& item);

    /// By class name and sensor label.
    const std::map<std::pair<std::string, std::string>, SensorSurvey>& sensors() const { return sensors_; }
    StampNs earliest_stamp_ns() const { return earliest_ns_; }
    StampNs latest_stamp_ns() const { return latest_ns_; }

    /// A sentence for each thing that is likely to spoil a run.
    std::vector<std::string> complaints() const;
    /// What is worth knowing, and no complaint.
    std::vector<std::string> remarks() const { return imus_.remarks(); }

 private:
    std::map<std::pair<std::string, std::string>, SensorSurvey> sensors_;
    StampNs earliest_ns_ = 0, latest_ns_ = 0;
    PlanarScan scan_;
    ImuSurvey imus_;
};

/// `CObservation2DRangeScan "FLASER"`
std::string sensor_name(const std::pair<std::string, std::string>& class_and_label);
/// "2006-01-21 09:03:45 UTC"
std::string utc_text(StampNs stamp_ns);
/// Seconds since `start_ns`, with three decimals.
std::string seconds_since(StampNs start_ns, StampNs stamp_ns);

}  // namespace loopline
