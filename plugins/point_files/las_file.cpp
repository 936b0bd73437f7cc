/// LAS: a header of bytes, then rows whose first three numbers are x, y and z. ASPRS, LAS specification 1.4,
/// 2013, whose fields that are used here stand where those of 1.0 stood.
#include <cmath>
#include <cstring>
#include <fstream>

#include "point_files/point_file.h"
#include "point_files/point_rows.h"

namespace loopline {
namespace {

constexpr std::size_t least_header_bytes = 227, header_with_long_count_bytes = 375, least_row_bytes = 20;
constexpr double far_m = 100e3;

template <class T>
T las_number(const std::string& bytes, std::size_t offset) {
    T value{};
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

std::string header_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) refuse_points(file, "can't be read");
    std::string bytes(header_with_long_count_bytes, '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    const auto count = static_cast<std::size_t>(in.gcount());
    if (count < 4 || bytes.compare(0, 4, "LASF") != 0) refuse_points(file, "is not a LAS file");
    if (count < least_header_bytes) refuse_points(file, "ends inside its header");
    return bytes;  // what lies behind a short one is not looked at
}

}  // namespace

std::shared_ptr<const PointFile> las_file(const std::filesystem::path& file) {
    const std::string header = header_of(file);
    if (las_number<std::uint8_t>(header, 104) >= 64)
        refuse_points(file, "is compressed, which can't be read; unpack it with laszip");
    PointRows rows;
    rows.file = file;
    rows.begin = las_number<std::uint32_t>(header, 96);
    rows.row_bytes = las_number<std::uint16_t>(header, 105);
    rows.points = las_number<std::uint32_t>(header, 107);
    if (las_number<std::uint16_t>(header, 94) >= header_with_long_count_bytes && rows.points == 0)
        rows.points = las_number<std::uint64_t>(header, 247);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        rows.axes[axis] = {Number::signed_integer, 4, 4 * axis};
        rows.unit_m[static_cast<int>(axis)] = las_number<double>(header, 131 + 8 * axis);
        rows.origin_m[static_cast<int>(axis)] = las_number<double>(header, 155 + 8 * axis);
    }
    if (rows.begin < least_header_bytes || rows.row_bytes < least_row_bytes || !rows.unit_m.allFinite() ||
        !rows.origin_m.allFinite())
        refuse_points(file, "has numbers in its header that no LAS file can have; it is damaged");
    if (rows.origin_m.head<2>().cwiseAbs().maxCoeff() > far_m)
        rows.grid_origin_m.head<2>() = rows.origin_m.head<2>();
    return std::make_shared<RowsOfFile>(std::move(rows));
}

}  // namespace loopline
