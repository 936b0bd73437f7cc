/// Where a local frame lies on the Earth.
#pragma once

#include <optional>

namespace loopline {

/// On WGS84: z up, x turned from east.
struct EarthFrame {
    double latitude_deg = 0, longitude_deg = 0, height_m = 0;  ///< of its origin; height above the ellipsoid
    double heading_deg = 0;                                    ///< of its x axis, counter-clockwise from east
    /// Geoid above the ellipsoid at the origin, as the receiver says: height - separation is "above the sea".
    std::optional<double> geoid_separation_m = std::nullopt;
};

}  // namespace loopline
