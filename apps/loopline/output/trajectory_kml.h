/// A path on the Earth for globes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "api/earth_frame.h"
#include "api/trajectory.h"

namespace loopline {

/// KML 2.2 with the final path twice: as a line, and as a gx:Track with the time of every vertex (UTC). KML
/// counts heights from the sea, so the receiver's separation of geoid and ellipsoid at the origin is taken
/// off them; where none is known they are above the ellipsoid, and the file says so. Nothing of it is held in
/// memory. Returns how many poses were left out because they are not finite.
std::size_t write_trajectory_kml(const std::filesystem::path& file, const Trajectory& trajectory,
                                 const EarthFrame& earth);

/// "2014-05-13T16:53:20.000000001Z", all digits of the integer.
std::string iso_time_text(StampNs stamp_ns);

}  // namespace loopline
