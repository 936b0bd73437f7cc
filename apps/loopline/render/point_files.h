/// Point clouds from files, for pictures of them.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace loopline {

/// The x, y, z of every vertex of a PLY file (ascii or binary_little_endian, in the vertex element's order;
/// other elements must come after it and hold no part in this). Points that are not finite are left out.
/// Throws CommandError(exit_input_data) with a sentence.
std::vector<Eigen::Vector3f> read_ply_points(const std::filesystem::path& file);

/// The same for a PCD file (DATA ascii or binary; binary_compressed is refused with a sentence).
std::vector<Eigen::Vector3f> read_pcd_points(const std::filesystem::path& file);

}  // namespace loopline
