/// Point clouds from files, for pictures of them.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <vector>

#include "render/point_source.h"

namespace loopline {

/// The x, y, z of a .ply, .pcd or .las file (point_files/point_file.h). Points on a grid of the Earth are
/// drawn where they lie from the file's own origin: a float has no room for both kilometres by the thousand
/// and centimetres. Throws CommandError(exit_input_data) with a sentence.
std::shared_ptr<const PointSource> points_of_file(const std::filesystem::path& file);

/// All that are finite, in memory.
std::vector<Eigen::Vector3f> finite_points(const PointSource& points);

}  // namespace loopline
