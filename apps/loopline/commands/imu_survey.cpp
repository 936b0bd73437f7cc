#include "commands/imu_survey.h"

#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>

#include "api/observation_class.h"
#include "commands/log_survey.h"
#include "inertial/imu_observation.h"
#include "inertial/imu_verdict.h"

namespace loopline {

void ImuSurvey::add(const StreamItem& item) {
    const auto* observation = item.observation.get();
    if (const auto* imu = as<mrpt::obs::CObservationIMU>(observation)) {
        auto& check = checks_[imu->sensorLabel];
        if (const auto reading = inertial::reading_from_mrpt(*imu, item.stamp_ns))
            check.add_imu(*reading);
        else
            check.add_incomplete();
    } else if (const auto* odometry = as<mrpt::obs::CObservationOdometry>(observation)) {
        if (!odometry_label_) odometry_label_ = odometry->sensorLabel;
        if (odometry->sensorLabel != *odometry_label_) return;
        const auto& pose = odometry->odometry;
        for (auto& [label, check] : checks_)
            check.add_odometry(item.stamp_ns, {pose.x(), pose.y(), pose.phi()});
    }
}

bool ImuSurvey::looks_at(const std::string& label) const {
    const auto found = checks_.find(label);
    return found != checks_.end() && found->second.stamps().count() > 0;
}

bool ImuSurvey::looks_at(const mrpt::obs::CObservation& observation) const {
    return as<mrpt::obs::CObservationIMU>(&observation) != nullptr && looks_at(observation.sensorLabel);
}

std::vector<std::string> ImuSurvey::complaints(StampNs log_start_ns) const {
    std::vector<std::string> sentences;
    for (const auto& [label, check] : checks_) {
        if (!looks_at(label)) continue;
        for (const auto& clause : inertial::imu_complaints(check, label, log_start_ns))
            sentences.push_back(sensor_name({"CObservationIMU", label}) + " " + clause);
    }
    return sentences;
}

std::vector<std::string> ImuSurvey::remarks() const {
    std::vector<std::string> sentences;
    for (const auto& [label, check] : checks_)
        if (const std::string clause = inertial::mounting_remark(check); looks_at(label) && !clause.empty())
            sentences.push_back(sensor_name({"CObservationIMU", label}) + " " + clause);
    return sentences;
}

}  // namespace loopline
