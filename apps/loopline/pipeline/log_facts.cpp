#include "pipeline/log_facts.h"

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/poses/CPose3D.h>

#include <array>
#include <cmath>
#include <cstring>
#include <set>

namespace loopline {
namespace {

using mrpt::obs::CObservation2DRangeScan;

bool differ(const mrpt::math::TPose3D& a, const mrpt::math::TPose3D& b) {
    constexpr double tolerance = 0.02;  // m and rad: a servo does not move that much from scan to scan
    return std::abs(a.x - b.x) > tolerance || std::abs(a.y - b.y) > tolerance ||
           std::abs(a.z - b.z) > tolerance || std::abs(std::remainder(a.yaw - b.yaw, 2 * M_PI)) > tolerance ||
           std::abs(a.pitch - b.pitch) > tolerance || std::abs(a.roll - b.roll) > tolerance;
}

std::string quoted(const std::string& label) {
    return label.empty() ? "no label" : "the label \"" + label + "\"";
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

SensorFacts& LogFacts::facts_of(const mrpt::obs::CObservation& observation) {
    const auto* class_id = observation.GetRuntimeClass();
    for (const auto& known : known_)
        if (known.class_id == class_id && known.label == observation.sensorLabel) return *known.facts;
    SensorFacts& facts = sensors_[{class_id->className, observation.sensorLabel}];
    known_.push_back({class_id, observation.sensorLabel, &facts});
    return facts;
}

void LogFacts::add(const mrpt::obs::CObservation& observation, StampNs stamp_ns) {
    if (observations_++ == 0) first_stamp_ns_ = stamp_ns;
    last_stamp_ns_ = stamp_ns;
    if (is_laser_scan(observation)) ++scans_;

    SensorFacts& sensor = facts_of(observation);
    if (sensor.count++ == 0) sensor.first_stamp_ns = stamp_ns;
    sensor.last_stamp_ns = stamp_ns;
    if (const auto* scan = dynamic_cast<const CObservation2DRangeScan*>(&observation)) {
        const auto pose = scan->sensorPose.asTPose();
        if (sensor.count == 1) {
            sensor.beams = scan->getScanSize();
            sensor.aperture_rad = scan->aperture;
            sensor.T_base_sensor = pose;
        } else if (!sensor.varies) {
            sensor.varies = sensor.beams != scan->getScanSize() ||
                            std::abs(sensor.aperture_rad - scan->aperture) > 1e-4F ||
                            (scan->deltaPitch == 0 && differ(pose, sensor.T_base_sensor));
        }
        sensor.T_base_sensor = pose;  // a servo may turn it bit by bit
    }
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
