/// Universal transverse Mercator: the grid of maps, 60 zones of 6 degrees.
#pragma once

#include <optional>

#include "gnss/geodetic.h"

namespace loopline::gnss {

struct Utm {
    int zone = 0;          ///< 1 .. 60
    bool north = true;     ///< of the equator; south of it, northings begin 10 000 km lower
    double easting_m = 0;  ///< 500 km on the central meridian
    double northing_m = 0;
    double convergence_rad = 0;  ///< direction of grid north, clockwise from true north
    double scale = 1;            ///< length on the grid by length on the ellipsoid
};

/// Of WGS 84 / UTM zone N in the EPSG's registry: 32601 .. 32660, in the south 32701 .. 32760.
inline int epsg_code(const Utm& utm) {
    return (utm.north ? 32600 : 32700) + utm.zone;
}

/// The zone of a place, with the exceptions of Norway (32V) and Svalbard (31X .. 37X). None beyond 84 degrees
/// north and 80 south, where UTM ends.
std::optional<int> utm_zone(double latitude_deg, double longitude_deg);

/// In its own zone; the height plays no part.
std::optional<Utm> to_utm(const Geodetic& place);
/// In a neighbouring zone or any other, so that a drive over an edge stays on one grid; exact to nanometres
/// up to 30 degrees from the zone's middle. `north` chooses the false northing.
Utm to_utm(const Geodetic& place, int zone, bool north);

/// Latitude and longitude of a point of the grid; its height is 0. Convergence and scale are not looked at.
Geodetic from_utm(const Utm& utm);

}  // namespace loopline::gnss
