/// A path on the Earth for GIS programs.
#pragma once

#include <cstddef>
#include <filesystem>

#include "api/results.h"
#include "api/trajectory.h"

namespace loopline {

/// RFC 7946: longitude and latitude in degrees and height in m above the ellipsoid, all on WGS84. Features,
/// by their property `kind`: `trajectory`, the final path, with the stamp and the standard deviations of
/// every vertex; `trajectory_online`, what was known at the time; `fixes`, those of the receiver with one
/// `fate` each. A path that crosses the meridian of 180 degrees is one feature a part. Nothing of it is held
/// in memory. Returns how many poses were left out because they are not finite.
std::size_t write_trajectory_geojson(const std::filesystem::path& file, const Trajectory& trajectory,
                                     const EarthFrame& earth, const PlacedFixes& fixes);

}  // namespace loopline
