/// Point clouds from files, for pictures of them.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <vector>

#include "render/point_source.h"

namespace loopline {

/// The x, y, z of a .ply, .pcd or .las file. Rows of bytes stay on disk; text is kept in memory. Throws
/// CommandError(exit_input_data) with a sentence.
std::shared_ptr<const PointSource> points_of_file(const std::filesystem::path& file);

/// Of a PLY file (ascii or binary_little_endian, in the vertex element's order; other elements must come
/// after it and hold no part in this).
std::shared_ptr<const PointSource> ply_points(const std::filesystem::path& file);
/// Of a PCD file (DATA ascii or binary; binary_compressed is refused with a sentence).
std::shared_ptr<const PointSource> pcd_points(const std::filesystem::path& file);
/// Of a LAS file, version 1.0 to 1.4, that is not compressed.
std::shared_ptr<const PointSource> las_points(const std::filesystem::path& file);

/// All that are finite, in memory.
std::vector<Eigen::Vector3f> finite_points(const PointSource& points);

}  // namespace loopline
