/// Point clouds as PLY and PCD, both binary (MRPT's own PCD writer is compiled out of the Debian packages).
#pragma once

#include <mrpt/maps/CPointsMap.h>

#include <cstddef>
#include <filesystem>

namespace loopline {

/// x y z as little-endian floats, metres, map frame. Return how many points were left out because they are
/// not finite.
std::size_t write_ply(const std::filesystem::path& file, const mrpt::maps::CPointsMap& points);
std::size_t write_pcd(const std::filesystem::path& file, const mrpt::maps::CPointsMap& points);

}  // namespace loopline
