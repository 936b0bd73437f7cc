#include "gnss/utm.h"

#include <algorithm>
#include <cmath>

#include "gnss/transverse_mercator.h"

namespace loopline::gnss {
namespace {

constexpr double central_scale = 0.9996;
constexpr double false_easting_m = 500e3, false_northing_south_m = 10000e3;

double central_meridian_deg(int zone) {
    return 6 * zone - 183;
}

}  // namespace

std::optional<int> utm_zone(double latitude_deg, double longitude_deg) {
    if (!(latitude_deg >= -80 && latitude_deg < 84) || !std::isfinite(longitude_deg)) return std::nullopt;
    const double longitude = wrapped_longitude_deg(longitude_deg);
    if (latitude_deg >= 56 && latitude_deg < 64 && longitude >= 3 && longitude < 6) return 32;
    if (latitude_deg >= 72 && longitude >= 0 && longitude < 42)
        return longitude < 9 ? 31 : longitude < 21 ? 33 : longitude < 33 ? 35 : 37;
    return std::min(60, static_cast<int>(std::floor((longitude + 180) / 6)) + 1);
}

std::optional<Utm> to_utm(const Geodetic& place) {
    const auto zone = utm_zone(place.latitude_deg, place.longitude_deg);
    if (!zone) return std::nullopt;
    return to_utm(place, *zone, place.latitude_deg >= 0);
}

Utm to_utm(const Geodetic& place, int zone, bool north) {
    const TransverseMercator grid =
        project(place.latitude_deg, wrapped_longitude_deg(place.longitude_deg - central_meridian_deg(zone)));
    return {zone,
            north,
            false_easting_m + central_scale * grid.east_m,
            (north ? 0 : false_northing_south_m) + central_scale * grid.north_m,
            grid.convergence_rad,
            central_scale * grid.scale};
}

Geodetic from_utm(const Utm& utm) {
    const double north_m = utm.northing_m - (utm.north ? 0 : false_northing_south_m);
    const PlaceBesideMeridian place =
        unproject((utm.easting_m - false_easting_m) / central_scale, north_m / central_scale);
    return {place.latitude_deg, wrapped_longitude_deg(place.longitude_deg + central_meridian_deg(utm.zone)),
            0};
}

}  // namespace loopline::gnss
