#include "api/planar_scan.h"

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>
#include <cmath>

namespace loopline {

std::size_t PlanarScan::returns() const {
    return static_cast<std::size_t>(
        std::count_if(ranges_m.begin(), ranges_m.end(), [](float r) { return r > 0; }));
}

bool is_usable(const mrpt::obs::CObservation2DRangeScan& observation) {
    const auto& pose = observation.sensorPose;
    const auto& rotation = pose.getRotationMatrix();  // its angles are computed only for those who need them
    return observation.getScanSize() >= 2 && std::isfinite(observation.aperture) &&
           observation.aperture > 0 && observation.aperture <= 2 * M_PI + 1e-3 && std::isfinite(pose.x()) &&
           std::isfinite(pose.y()) &&
           std::all_of(rotation.begin(), rotation.end(), [](double entry) { return std::isfinite(entry); });
}

bool to_planar_scan(const mrpt::obs::CObservation2DRangeScan& observation, PlanarScan& scan) {
    scan.ranges_m.clear();
    if (!is_usable(observation)) return false;
    const std::size_t beams = observation.getScanSize();
    const auto& pose = observation.sensorPose;
    const Pose2 T_base_sensor{pose.x(), pose.y(), pose.yaw()};

    scan.first_angle_rad = -0.5 * observation.aperture;
    scan.angle_step_rad = observation.aperture / static_cast<double>(beams - 1);
    scan.max_range_m =
        std::isfinite(observation.maxRange) && observation.maxRange > 0 ? observation.maxRange : 1e3;
    scan.sigma_range_m =
        std::isfinite(observation.stdError) && observation.stdError > 0 ? observation.stdError : 0;
    scan.T_base_sensor = T_base_sensor;
    scan.ranges_m.resize(beams);
    // The ranges lie in one vector: one checked call instead of one a beam.
    const float* const ranges_m = &observation.getScanRange(0);
    const float max_range_m = static_cast<float>(scan.max_range_m);
    for (std::size_t i = 0; i < beams; ++i) {
        // rightToLeft is counter-clockwise; a clockwise scan is turned round.
        const std::size_t source = observation.rightToLeft ? i : beams - 1 - i;
        const float range_m = ranges_m[source];
        const bool usable = range_m > 0 && range_m < max_range_m && observation.getScanRangeValidity(source);
        scan.ranges_m[i] = usable ? range_m : 0.0f;
    }
    return true;
}

}  // namespace loopline
