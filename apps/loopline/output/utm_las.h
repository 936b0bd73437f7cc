/// Points of a map that is placed on the Earth, on the UTM grid, as a LAS file that GIS programs know to
/// place.
#pragma once

#include <mrpt/maps/CPointsMap.h>

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>

#include "api/stored_cloud.h"
#include "gnss/geo_reference.h"
#include "gnss/utm.h"

namespace loopline {

struct LasPointOnMap {
    Eigen::Vector3d p_map_m;
    std::uint16_t intensity = 0;
    double after_first_s = 0;
};

/// Points that may be larger than memory.
struct PointsOnMap {
    std::size_t count = 0;
    double reach_m = 0;  ///< none is farther from the map's origin along an axis
    StampNs first_ns = 0;
    std::function<void(const std::function<void(const LasPointOnMap&)>&)> for_each;
};
/// They outlive what is made of them. Points that are not finite are left out.
PointsOnMap points_on_map(const StoredCloud& cloud);
PointsOnMap points_on_map(const mrpt::maps::CPointsMap& map, StampNs first_ns);

/// The zone that the map's origin lies in; none where UTM is not defined, near the poles.
std::optional<gnss::Utm> grid_of(const gnss::GeoReference& reference);

/// LAS 1.2 with easting and northing of each point for itself (a map's straight axes are no grid: scale and
/// convergence of UTM change from place to place), and its height above the ellipsoid. All of it in the zone
/// and hemisphere of `grid`, as whole numbers of 0.1 mm (of 1 mm where the map reaches farther than 200 km)
/// from the origin, itself rounded to whole metres. At most most_las_points.
void write_utm_las(const std::filesystem::path& file, const PointsOnMap& points,
                   const gnss::GeoReference& reference, const gnss::Utm& grid);

}  // namespace loopline
