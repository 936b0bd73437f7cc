/// Point clouds from files. Rows of bytes stay on disk, since a cloud may be larger than memory; text is kept
/// in memory.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>

namespace loopline {

/// One sentence: "FILE WHAT".
struct PointFileError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class PointFile {
 public:
    using Use = std::function<void(const Eigen::Vector3d& p_m)>;
    virtual ~PointFile() = default;
    virtual std::size_t size() const = 0;
    /// Calls `use` with every `stride`-th point; some may not be finite. Throws PointFileError if the file
    /// has become shorter.
    virtual void for_each(std::size_t stride, const Use& use) const = 0;
    /// Of a LAS file on a grid of the Earth: the place there that its numbers count from, without the height;
    /// else 0.
    virtual Eigen::Vector3d grid_origin_m() const { return Eigen::Vector3d::Zero(); }
};

/// The x, y, z of a .ply, .las or, whatever else it is called, PCD file. Throws PointFileError.
std::shared_ptr<const PointFile> open_point_file(const std::filesystem::path& file);

/// Of a PLY file (ascii or binary_little_endian, in the vertex element's order; other elements must come
/// after it and hold no part in this).
std::shared_ptr<const PointFile> ply_file(const std::filesystem::path& file);
/// Of a PCD file (DATA ascii or binary; binary_compressed is refused with a sentence).
std::shared_ptr<const PointFile> pcd_file(const std::filesystem::path& file);
/// Of a LAS file, version 1.0 to 1.4, that is not compressed.
std::shared_ptr<const PointFile> las_file(const std::filesystem::path& file);

}  // namespace loopline
