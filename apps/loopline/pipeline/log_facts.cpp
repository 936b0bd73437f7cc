#include "pipeline/log_facts.h"

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>

#include "api/observation_class.h"

namespace loopline {
namespace {

using mrpt::obs::CObservation2DRangeScan;

bool differ(const mrpt::poses::CPose3D& T_base_a, const mrpt::poses::CPose3D& T_base_b) {
    if (T_base_a.m_coords == T_base_b.m_coords &&
        T_base_a.getRotationMatrix() == T_base_b.getRotationMatrix())
        return false;
    const mrpt::math::TPose3D a = T_base_a.asTPose(), b = T_base_b.asTPose();
    constexpr double tolerance = 0.02;  // m and rad: a servo does not move that much from scan to scan
    return std::abs(a.x - b.x) > tolerance || std::abs(a.y - b.y) > tolerance ||
           std::abs(a.z - b.z) > tolerance || std::abs(std::remainder(a.yaw - b.yaw, 2 * M_PI)) > tolerance ||
           std::abs(a.pitch - b.pitch) > tolerance || std::abs(a.roll - b.roll) > tolerance;
}

std::string quoted(const std::string& label) {
    return label.empty() ? "no label" : "the label \"" + label + "\"";
}

/// The latest of the scans that the sensor's count says.
void add_scan(const CObservation2DRangeScan& scan, SensorFacts& sensor) {
    if (sensor.count == 1) {
        sensor.beams = scan.getScanSize();
        sensor.aperture_rad = scan.aperture;
    } else if (!sensor.varies) {
        sensor.varies = sensor.beams != scan.getScanSize() ||
                        std::abs(sensor.aperture_rad - scan.aperture) > 1e-4F ||
                        (scan.deltaPitch == 0 && differ(scan.sensorPose, sensor.T_base_sensor));
    }
    sensor.T_base_sensor = scan.sensorPose;  // a servo may turn it bit by bit
}

}  // namespace

std::string short_class_name(const std::string& name) {
    const auto colon = name.rfind(':');
    return colon == std::string::npos ? name : name.substr(colon + 1);
}

bool is_laser_scan(const mrpt::obs::CObservation& observation) {
    const char* name = observation.GetRuntimeClass()->className;
    const char* colon = std::strrchr(name, ':');
    if (colon != nullptr) name = colon + 1;
    constexpr std::array<const char*, 5> classes = {
        "CObservation2DRangeScan", "CObservation2DRangeScanWithUncertainty", "CObservationVelodyneScan",
        "CObservationRotatingScan", "CObservationPointCloud"};
    for (const char* known : classes)
        if (std::strcmp(name, known) == 0) return true;
    return false;
}

const LogFacts::Known& LogFacts::known(const mrpt::obs::CObservation& observation) {
    const auto* class_id = observation.GetRuntimeClass();
    for (const auto& known : known_)
        if (known.class_id == class_id && known.label == observation.sensorLabel) return known;
    SensorFacts& facts = sensors_[{class_id->className, observation.sensorLabel}];
    known_.push_back({class_id, observation.sensorLabel, &facts, is_laser_scan(observation),
                      as<CObservation2DRangeScan>(&observation) != nullptr});
    return known_.back();
}

void LogFacts::add(const mrpt::obs::CObservation& observation, StampNs stamp_ns) {
    const Known& sensor = known(observation);
    if (observations_++ == 0) first_stamp_ns_ = last_stamp_ns_ = stamp_ns;
    first_stamp_ns_ = std::min(first_stamp_ns_, stamp_ns);
    last_stamp_ns_ = std::max(last_stamp_ns_, stamp_ns);
    latest_is_scan_ = sensor.is_scan;
    if (latest_is_scan_) ++scans_;
    if (sensor.facts->count++ == 0) sensor.facts->first_stamp_ns = stamp_ns;
    sensor.facts->last_stamp_ns = stamp_ns;
    if (sensor.is_planar_scan)
        add_scan(static_cast<const CObservation2DRangeScan&>(observation), *sensor.facts);
}

bool LogFacts::has_class(const std::string& name) const {
    for (const auto& [key, sensor] : sensors_)
        if (short_class_name(key.first) == short_class_name(name)) return true;
    return false;
}

std::string LogFacts::inventory() const {
    std::string text;
    for (const auto& [key, sensor] : sensors_)
        text += (text.empty() ? "" : ", ") + std::to_string(sensor.count) + " " +
                short_class_name(key.first) + (key.second.empty() ? "" : " (" + key.second + ")");
    return text.empty() ? "nothing" : text;
}

std::string undrawn_map(const ModuleInfo& builder, const LogFacts& facts) {
    for (const auto& need : builder.needs)
        if (!facts.has_class(need))
            return "no map " + builder.name + " is drawn: it needs " + need + ", and this log holds " +
                   facts.inventory();
    return {};
}

std::vector<std::string> LogFacts::label_warnings() const {
    std::vector<std::string> warnings;
    std::map<std::string, std::set<std::string>> classes_of_label;
    for (const auto& [key, sensor] : sensors_) {
        classes_of_label[key.second].insert(short_class_name(key.first));
        if (sensor.varies)
            warnings.push_back(
                "two laser scanners seem to share " + quoted(key.second) +
                ": its scans differ in their beams, aperture or place on the vehicle; give each its own");
    }
    for (const auto& [label, classes] : classes_of_label) {
        if (label.empty() || classes.size() < 2) continue;
        std::string names;
        for (const auto& name : classes) names += (names.empty() ? "" : " and ") + name;
        warnings.push_back("two sensors share " + quoted(label) + ": " + names + "; give each its own");
    }
    return warnings;
}

}  // namespace loopline
