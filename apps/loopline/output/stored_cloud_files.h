/// Clouds that may be larger than memory, as PLY, PCD and LAS files.
#pragma once

#include <cstddef>
#include <filesystem>

#include "api/stored_cloud.h"

namespace loopline {

/// Binary, with x, y, z (m, map frame), intensity (part of full scale, if the log has it) and time_s (after
/// the cloud's first moment, which a comment tells). Coordinates are float, or double where that would be
/// wrong by more than a quarter of a millimetre: farther than 4 km from the origin.
void write_ply(const std::filesystem::path& file, const StoredCloud& cloud);
void write_pcd(const std::filesystem::path& file, const StoredCloud& cloud);

/// LAS 1.2, point format 1: whole numbers of 0.1 mm, intensity, and GPS time less 1e9 s. (ASPRS, LAS
/// specification version 1.2, 2008.)
void write_las(const std::filesystem::path& file, const StoredCloud& cloud);
constexpr std::size_t most_las_points = 4'294'967'295;

/// What GPS time is ahead of UTC then, in whole seconds: leap seconds since 1980, known up to 2017, when the
/// last one was put in.
int gps_ahead_of_utc_s(StampNs stamp_ns);

}  // namespace loopline
