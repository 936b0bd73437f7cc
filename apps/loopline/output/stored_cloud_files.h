/// Clouds that may be larger than memory, as PLY, PCD and LAS files.
#pragma once

#include <filesystem>

#include "api/stored_cloud.h"

namespace loopline {

/// Binary, with x, y, z (m, map frame), intensity (part of full scale, if the log has it) and time_s (after
/// the cloud's first moment, which a comment tells). Coordinates are float, or double where that would be
/// wrong by more than a quarter of a millimetre: farther than 4 km from the origin.
void write_ply(const std::filesystem::path& file, const StoredCloud& cloud);
void write_pcd(const std::filesystem::path& file, const StoredCloud& cloud);

/// LAS in the map frame, without a coordinate system: whole numbers of 0.1 mm, intensity, and GPS time less
/// 1e9 s. At most most_las_points.
void write_las(const std::filesystem::path& file, const StoredCloud& cloud);

}  // namespace loopline
