/// Points of a file in rows of bytes, read anew each time they are asked for: a cloud may be larger than
/// memory.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "point_files/point_file.h"

namespace loopline {

enum class Number { signed_integer, unsigned_integer, real };

/// A number in each row.
struct PointColumn {
    Number number = Number::real;
    std::size_t bytes = 4;         ///< 1, 2, 4 or 8
    std::size_t offset_bytes = 0;  ///< from the beginning of the row
};

/// Where points lie in a file.
struct PointRows {
    std::filesystem::path file;
    std::uint64_t begin = 0;  ///< of the first row, in bytes
    std::uint64_t points = 0;
    std::size_t row_bytes = 0;
    std::array<PointColumn, 3> axes;  ///< x, y, z
    Eigen::Vector3d unit_m = Eigen::Vector3d::Ones(), origin_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d grid_origin_m = Eigen::Vector3d::Zero();  ///< as PointFile has it
};

class RowsOfFile : public PointFile {
 public:
    /// Throws PointFileError where the file has fewer rows than it says.
    explicit RowsOfFile(PointRows rows);
    std::size_t size() const override { return static_cast<std::size_t>(rows_.points); }
    void for_each(std::size_t stride, const Use& use) const override;
    Eigen::Vector3d grid_origin_m() const override { return rows_.grid_origin_m; }

 private:
    Eigen::Vector3d point_at(const char* row) const;
    [[noreturn]] void refuse_after(std::uint64_t row) const;

    PointRows rows_;
};

/// Throws PointFileError: "FILE WHAT".
[[noreturn]] void refuse_points(const std::filesystem::path& file, const std::string& what);

}  // namespace loopline
