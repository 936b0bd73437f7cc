/// Covariance of every pose of the final estimate, 6x6, as CSV.
#pragma once

#include <cstddef>
#include <filesystem>

#include "api/trajectory.h"

namespace loopline {

/// Header, then a row a pose: stamp and the 36 entries row by row. Parameters in the order x y z roll pitch
/// yaw, of T_map_base; units are in the column names. Returns how many rows were left out because they are
/// not finite.
std::size_t write_covariance_csv(const std::filesystem::path& file, const Trajectory& trajectory);

}  // namespace loopline
