/// The line map as GeoJSON, for QGIS and other map programs.
#pragma once

#include <cstddef>
#include <filesystem>

#include "api/line_map.h"

namespace loopline {

/// A FeatureCollection of LineStrings from start to end point, in metres of the map frame. RFC 7946 knows no
/// local coordinates and has withdrawn the "crs" member; it leaves other coordinates to prior arrangement, so
/// the collection says so in words. Returns how many lines were left out because they are not finite.
std::size_t write_line_map_geojson(const std::filesystem::path& file, const LineMap& lines);

}  // namespace loopline
