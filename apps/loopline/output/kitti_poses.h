/// Poses as the KITTI odometry tools read them: the upper 3x4 of a transform, twelve numbers a line.
#pragma once

#include <cstddef>
#include <filesystem>

#include "api/trajectory.h"

namespace loopline {

/// T_map_base of the final estimate, row by row, in log order, in our own axes (x forward, y left, z up;
/// KITTI's files are in camera axes, which its length and angle errors do not depend on). The format has no
/// time; trajectory.tum has the same poses in the same order. Returns how many poses were left out because
/// they are not finite.
std::size_t write_kitti_poses(const std::filesystem::path& file, const Trajectory& trajectory);

}  // namespace loopline
