#include "point_files/point_rows.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <vector>

namespace loopline {
namespace {

constexpr std::size_t bytes_at_once = 1 << 16;

double value_at(const char* bytes, const PointColumn& column) {
    const auto as = [bytes](auto zero) {
        std::memcpy(&zero, bytes, sizeof zero);
        return static_cast<double>(zero);
    };
    if (column.number == Number::real) return column.bytes == 8 ? as(0.0) : as(0.f);
    const bool is_signed = column.number == Number::signed_integer;
    switch (column.bytes) {
        case 1:
            return is_signed ? as(std::int8_t{}) : as(std::uint8_t{});
        case 2:
            return is_signed ? as(std::int16_t{}) : as(std::uint16_t{});
        case 4:
            return is_signed ? as(std::int32_t{}) : as(std::uint32_t{});
        default:
            return is_signed ? as(std::int64_t{}) : as(std::uint64_t{});
    }
}

}  // namespace

void refuse_points(const std::filesystem::path& file, const std::string& what) {
    throw PointFileError(file.string() + " " + what);
}

RowsOfFile::RowsOfFile(PointRows rows) : rows_(std::move(rows)) {
    std::error_code error;
    const std::uint64_t bytes = std::filesystem::file_size(rows_.file, error);
    if (error) refuse_points(rows_.file, "can't be read");
    const std::uint64_t there = bytes < rows_.begin ? 0 : (bytes - rows_.begin) / rows_.row_bytes;
    if (there < rows_.points) refuse_after(there);
}

void RowsOfFile::refuse_after(std::uint64_t row) const {
    refuse_points(rows_.file, "ends after " + std::to_string(row) + " of " + std::to_string(rows_.points) +
                                  " points; it was not written to its end");
}

Eigen::Vector3d RowsOfFile::point_at(const char* row) const {
    Eigen::Vector3d p_m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const PointColumn& column = rows_.axes[axis];
        p_m[static_cast<int>(axis)] = value_at(row + column.offset_bytes, column);
    }
    return rows_.origin_m + rows_.unit_m.cwiseProduct(p_m);
}

void RowsOfFile::for_each(std::size_t stride, const Use& use) const {
    std::ifstream in(rows_.file, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(rows_.begin));
    const std::size_t rows_at_once = std::max<std::size_t>(1, bytes_at_once / rows_.row_bytes);
    std::vector<char> bytes(rows_at_once * rows_.row_bytes);
    std::uint64_t next = 0;
    for (std::uint64_t first = 0; first < rows_.points; first += rows_at_once) {
        const std::uint64_t end = std::min<std::uint64_t>(rows_.points, first + rows_at_once);
        if (!in.read(bytes.data(), static_cast<std::streamsize>((end - first) * rows_.row_bytes)))
            refuse_after(first);
        for (; next < end; next += stride) use(point_at(bytes.data() + (next - first) * rows_.row_bytes));
    }
}

}  // namespace loopline
