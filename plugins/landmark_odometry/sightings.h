/// Landmarks by range and bearing, in the vehicle's plane.
#pragma once

#include <cmath>
#include <vector>

#include "landmark_odometry/landmark_filter.h"

namespace mrpt::obs {
class CObservationBearingRange;
}

namespace loopline::landmark_odometry {

struct SightingSettings {
    double sigma_range_m = 0.1, sigma_bearing_rad = 0.5 * M_PI / 180;
    double max_range_m = 60;
};

/// Those that are near enough and numbers, as the sensor's mount has them; along and across the beam they err
/// by range and bearing.
std::vector<Sighting> sightings_of(const mrpt::obs::CObservationBearingRange& observation,
                                   const SightingSettings& settings);

}  // namespace loopline::landmark_odometry
