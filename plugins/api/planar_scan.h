/// One sweep of a planar laser, as the algorithms see it: cleaned numbers, no MRPT type.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "api/pose2.h"

namespace mrpt::obs {
class CObservation2DRangeScan;
}

namespace loopline {

/// Beams in the order of their angle, counter-clockwise, whatever the sensor's own sense was.
struct PlanarScan {
    double first_angle_rad = 0;  ///< of beam 0, in the sensor frame, counter-clockwise from x
    double angle_step_rad = 0;   ///< > 0
    double max_range_m = 0;
    /// Range per beam; 0 where there is no usable return (invalid, NaN, infinite, not positive, at or beyond max range).
    std::vector<float> ranges_m;
    Pose2 T_base_sensor;         ///< where the sensor sits on the vehicle, projected on the ground plane
    double sigma_range_m = 0;    ///< range noise as the sensor states it; 0 where it does not

    std::size_t size() const { return ranges_m.size(); }
    bool has_return(std::size_t beam) const { return ranges_m[beam] > 0; }
    double angle_rad(std::size_t beam) const { return first_angle_rad + static_cast<double>(beam) * angle_step_rad; }
    Eigen::Vector2d point_sensor_m(std::size_t beam) const {
        const double a = angle_rad(beam), r = ranges_m[beam];
        return {r * std::cos(a), r * std::sin(a)};
    }
    std::size_t returns() const;
};

/// Whether a scan can be used: some beams, a finite aperture above 0, a sensor pose that is finite.
bool is_usable(const mrpt::obs::CObservation2DRangeScan& observation);

/// Reads an MRPT scan into `scan`, reusing its memory. Returns false, and leaves no beam, if the scan can't be used.
bool to_planar_scan(const mrpt::obs::CObservation2DRangeScan& observation, PlanarScan& scan);

}  // namespace loopline
