#include "landmark_odometry/sightings.h"

#include <mrpt/obs/CObservationBearingRange.h>

#include "api/mrpt_pose.h"

namespace loopline::landmark_odometry {

std::vector<Sighting> sightings_of(const mrpt::obs::CObservationBearingRange& observation,
                                   const SightingSettings& settings) {
    const Pose3 T_base_sensor = pose3_from_mrpt(observation.sensorLocationOnRobot);
    std::vector<Sighting> sightings;
    for (const auto& seen : observation.sensedData) {
        const double range_m = seen.range, yaw_rad = seen.yaw, pitch_rad = seen.pitch;
        if (!(range_m > 0 && range_m <= settings.max_range_m) || !std::isfinite(yaw_rad) ||
            !std::isfinite(pitch_rad))
            continue;
        const double level = std::cos(pitch_rad);
        const Eigen::Vector3d away(level * std::cos(yaw_rad), level * std::sin(yaw_rad),
                                   -std::sin(pitch_rad));
        const Eigen::Vector3d left(-std::sin(yaw_rad), std::cos(yaw_rad), 0);
        Eigen::Matrix2d J;
        J << (T_base_sensor.rotation * away).head<2>() * settings.sigma_range_m,
            (T_base_sensor.rotation * left).head<2>() * level * range_m * settings.sigma_bearing_rad;
        sightings.push_back({(T_base_sensor * Eigen::Vector3d(range_m * away)).head<2>(), J * J.transpose()});
    }
    return sightings;
}

}  // namespace loopline::landmark_odometry
