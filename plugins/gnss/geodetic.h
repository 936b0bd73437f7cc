/// Places on the Earth.
#pragma once

#include <cmath>

namespace loopline::gnss {

/// WGS84, the ellipsoid of GNSS receivers.
namespace wgs84 {
constexpr double a_m = 6378137;                       ///< semi-major axis
constexpr double flattening = 1 / 298.257223563;      ///< f
constexpr double e2 = flattening * (2 - flattening);  ///< first eccentricity, squared
constexpr double n = flattening / (2 - flattening);   ///< third flattening
constexpr double b_m = a_m * (1 - flattening);        ///< semi-minor axis
}  // namespace wgs84

/// In degrees, as receivers and files give it: to radians and back would not be exact.
struct Geodetic {
    double latitude_deg = 0;   ///< north is positive
    double longitude_deg = 0;  ///< east is positive
    double height_m = 0;       ///< above the ellipsoid
};

constexpr double rad_per_deg = M_PI / 180;

/// The same direction within [-180, 180).
inline double wrapped_longitude_deg(double longitude_deg) {
    const double rest = std::remainder(longitude_deg, 360);
    return rest == 180 ? -180 : rest;
}

}  // namespace loopline::gnss
