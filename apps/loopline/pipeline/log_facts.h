/// What a log turned out to hold, and what a user should know about it: gathered while it streams by.
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "api/module.h"
#include "api/stamp.h"

namespace loopline {

/// One sensor: observations of one class under one label.
struct SensorFacts {
    std::uint64_t count = 0;
    StampNs first_stamp_ns = 0;
    StampNs last_stamp_ns = 0;
    std::size_t beams = 0;               ///< of the first scan; 0 if it is no planar scan
    float aperture_rad = 0;              ///< of the first scan
    mrpt::poses::CPose3D T_base_sensor;  ///< of the last scan
    bool varies = false;  ///< beams, aperture or, but for a servo, its place on the vehicle changed
};

class LogFacts {
 public:
    using SensorKey = std::pair<std::string, std::string>;  ///< class name as MRPT writes it, sensorLabel

    void add(const mrpt::obs::CObservation& observation, StampNs stamp_ns);
    /// Whether the latest one gives laser ranges.
    bool latest_is_scan() const { return latest_is_scan_; }

    const std::map<SensorKey, SensorFacts>& sensors() const { return sensors_; }
    std::uint64_t observations() const { return observations_; }
    /// Laser scans: planar ones, turning ones, and clouds of spatial scanners.
    std::uint64_t scans() const { return scans_; }
    StampNs first_stamp_ns() const { return first_stamp_ns_; }  ///< the earliest
    StampNs last_stamp_ns() const { return last_stamp_ns_; }

    /// Whether any observation is of this class, named with or without its namespace.
    bool has_class(const std::string& name) const;
    /// "224 CObservation2DRangeScan (LASER), 224 CObservationOdometry (odometry)"; "nothing" if it is empty.
    std::string inventory() const;
    /// A sentence for each label that two different sensors seem to share.
    std::vector<std::string> label_warnings() const;

 private:
    struct Known {
        const mrpt::rtti::TRuntimeClassId* class_id;
        std::string label;
        SensorFacts* facts;
        bool is_scan, is_planar_scan;
    };
    const Known& known(const mrpt::obs::CObservation& observation);

    std::map<SensorKey, SensorFacts> sensors_;
    std::vector<Known> known_;  ///< the same, without making names for each observation
    std::uint64_t observations_ = 0, scans_ = 0;
    bool latest_is_scan_ = false;
    StampNs first_stamp_ns_ = 0, last_stamp_ns_ = 0;
};

/// A sentence if the map builder can't draw anything from such a log; empty if it can.
std::string undrawn_map(const ModuleInfo& builder, const LogFacts& facts);

/// "mrpt::obs::CObservationGPS" without its namespaces.
std::string short_class_name(const std::string& name);
/// An observation that gives laser ranges.
bool is_laser_scan(const mrpt::obs::CObservation& observation);

}  // namespace loopline
