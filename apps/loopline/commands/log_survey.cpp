#include "commands/log_survey.h"

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>

#include "pipeline/log_facts.h"

namespace loopline {

StampNs SensorSurvey::median_step_ns() const {
    if (steps_ns.empty()) return 0;
    auto steps = steps_ns;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    return *middle;
}

void LogSurvey::add(const StreamItem& item) {
    const bool first_of_all = sensors_.empty();
    earliest_ns_ = first_of_all ? item.stamp_ns : std::min(earliest_ns_, item.stamp_ns);
    latest_ns_ = first_of_all ? item.stamp_ns : std::max(latest_ns_, item.stamp_ns);

    imus_.add(item);
    const auto& observation = *item.observation;
    auto& sensor =
        sensors_[{short_class_name(observation.GetRuntimeClass()->className), observation.sensorLabel}];
    if (sensor.count == 0) {
        sensor.first_stamp_ns = item.stamp_ns;
    } else {
        const StampNs step_ns = item.stamp_ns - sensor.last_stamp_ns;
        if (!imus_.looks_at(observation)) sensor.steps_ns.push_back(step_ns);
        sensor.repeated_stamps += step_ns == 0;
        if (step_ns > sensor.longest_gap_ns) {
            sensor.longest_gap_ns = step_ns;
            sensor.longest_gap_start_ns = sensor.last_stamp_ns;
        }
    }
    sensor.last_stamp_ns = item.stamp_ns;
    ++sensor.count;
    if (const auto* scan = dynamic_cast<const mrpt::obs::CObservation2DRangeScan*>(&observation))
        sensor.empty_scans += !to_planar_scan(*scan, scan_) || scan_.returns() == 0;
}

std::vector<std::string> LogSurvey::complaints() const {
    // A pause this much longer than the usual step, and at least this long, is worth a look.
    constexpr StampNs gap_in_steps = 10, shortest_gap_ns = 1'000'000'000;
    std::vector<std::string> sentences;
    for (const auto& [key, sensor] : sensors_) {
        if (key.first == "CObservationIMU" && imus_.looks_at(key.second))
            continue;  // its own check says more
        const std::string name = sensor_name(key);
        const StampNs usual_ns = sensor.median_step_ns();
        if (sensor.longest_gap_ns > std::max(shortest_gap_ns, gap_in_steps * usual_ns))
            sentences.push_back(name + " pauses for " + seconds_since(0, sensor.longest_gap_ns) +
                                " s, from " + seconds_since(earliest_ns_, sensor.longest_gap_start_ns) +
                                " s on; its usual step is " + seconds_since(0, usual_ns) + " s");
        if (sensor.repeated_stamps > 0)
            sentences.push_back(name + " has " + std::to_string(sensor.repeated_stamps) +
                                " observations with the stamp of the one before");
        if (sensor.empty_scans > 0)
            sentences.push_back(name + " has " + std::to_string(sensor.empty_scans) +
                                " scans without a usable return");
    }
    const auto of_imus = imus_.complaints(earliest_ns_);
    sentences.insert(sentences.end(), of_imus.begin(), of_imus.end());
    return sentences;
}

std::string sensor_name(const std::pair<std::string, std::string>& class_and_label) {
    const auto& [name, label] = class_and_label;
    return label.empty() ? name : name + " \"" + label + "\"";
}

std::string utc_text(StampNs stamp_ns) {
    const std::time_t seconds = static_cast<std::time_t>(stamp_ns / 1'000'000'000);
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    std::array<char, 64> text{};
    return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &parts)};
}

std::string seconds_since(StampNs start_ns, StampNs stamp_ns) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.3f", seconds_between(start_ns, stamp_ns));
    return text.data();
}

}  // namespace loopline
