#include "output/las_format.h"

#include <algorithm>
#include <ctime>
#include <utility>

#include "output/binary_row.h"

namespace loopline {
namespace {

constexpr std::int64_t ns_in_s = 1'000'000'000;
constexpr std::int64_t gps_epoch_s = 315'964'800;  ///< 1980-01-06, of UTC

constexpr std::uint16_t header_bytes = 227, record_header_bytes = 54, point_bytes = 28;
constexpr std::size_t bounds_offset = 179;

void write_padded(OutputFile& out, std::string text, std::size_t width) {
    text.resize(width, '\0');
    out.text(text);
}

/// Day of the year from 1, and year, of a stamp.
std::pair<std::uint16_t, std::uint16_t> date_of(StampNs stamp_ns) {
    const std::time_t seconds = stamp_ns / ns_in_s;
    std::tm date{};
    gmtime_r(&seconds, &date);
    return {static_cast<std::uint16_t>(date.tm_yday + 1), static_cast<std::uint16_t>(date.tm_year + 1900)};
}

/// Keys of GeoTIFF 1.0 (Ritter and Ruth 2000), each with the place of its value: 0 is the key itself, else
/// the record of that number.
struct GeoKey {
    std::uint16_t key, place, count, value;
};
constexpr std::uint16_t key_directory = 34735, ascii_parameters = 34737;
constexpr std::uint16_t metre = 9001;

std::array<GeoKey, 5> keys_of(const LasCoordinateSystem& system) {
    const auto citation_bytes = static_cast<std::uint16_t>(system.citation.size() + 1);
    return {{{1024, 0, 1, 1},                              // the system is a projected one
             {1026, ascii_parameters, citation_bytes, 0},  // citation
             {3072, 0, 1, static_cast<std::uint16_t>(system.projected_epsg)},
             {3076, 0, 1, metre},
             {4099, 0, 1, metre}}};  // heights
}

std::string ascii_text(const LasCoordinateSystem& system) {
    return system.citation + "|";  // which ends a text in GeoTIFF
}

void write_record_header(OutputFile& out, std::uint16_t id, std::size_t bytes, const char* description) {
    BinaryRow row;
    row.add(std::uint16_t{0}).write(out);
    write_padded(out, "LASF_Projection", 16);
    row.add(id).add(static_cast<std::uint16_t>(bytes)).write(out);
    write_padded(out, description, 32);
}

void write_records(OutputFile& out, const LasCoordinateSystem& system) {
    const auto keys = keys_of(system);
    const std::string ascii = ascii_text(system);
    BinaryRow row;
    write_record_header(out, key_directory, 8 * (keys.size() + 1), "GeoTIFF keys");
    row.add(std::uint16_t{1}).add(std::uint16_t{1}).add(std::uint16_t{0});  // version 1, revision 1.0
    row.add(static_cast<std::uint16_t>(keys.size())).write(out);
    for (const GeoKey& key : keys) row.add(key.key).add(key.place).add(key.count).add(key.value).write(out);
    write_record_header(out, ascii_parameters, ascii.size() + 1, "GeoTIFF texts");
    write_padded(out, ascii, ascii.size() + 1);
}

std::size_t record_bytes(const LasCoordinateSystem& system) {
    return 2 * record_header_bytes + 8 * (keys_of(system).size() + 1) + ascii_text(system).size() + 1;
}

/// As they stand in the header: of each axis the highest and the lowest.
std::array<double, 6> bounds_of(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m) {
    return {high_m.x(), low_m.x(), high_m.y(), low_m.y(), high_m.z(), low_m.z()};
}

}  // namespace

void write_las_header(OutputFile& out, const LasHeader& header) {
    const auto [day, year] = date_of(header.first_ns);
    const std::size_t records = header.system != nullptr ? record_bytes(*header.system) : 0;
    BinaryRow row;
    out.text("LASF");
    row.add(std::uint16_t{0}).add(std::uint16_t{1}).write(out);  // source; time is GPS time less 1e9 s
    write_padded(out, "", 16);                                   // project
    row.add(std::uint8_t{1}).add(std::uint8_t{2}).write(out);
    write_padded(out, "EXTRACTION", 32);
    write_padded(out, "Loopline", 32);
    row.add(day).add(year).add(header_bytes).add(static_cast<std::uint32_t>(header_bytes + records));
    row.add(std::uint32_t{header.system != nullptr ? 2u : 0u});
    row.add(std::uint8_t{1}).add(point_bytes).add(header.points).write(out);
    row.add(header.points).write(out);  // by number of return: each is the first of one
    for (int i = 1; i < 5; ++i) row.add(std::uint32_t{0}).write(out);
    for (int axis = 0; axis < 3; ++axis) row.add(header.unit_m);
    for (int axis = 0; axis < 3; ++axis) row.add(header.offset_m[axis]);
    row.write(out);
    const auto bounds_m = bounds_of(header.low_m, header.high_m);
    out.bytes(bounds_m.data(), sizeof bounds_m);
    if (header.system != nullptr) write_records(out, *header.system);
}

void overwrite_las_bounds(OutputFile& out, const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m) {
    const auto bounds_m = bounds_of(low_m, high_m);
    out.overwrite(bounds_offset, bounds_m.data(), sizeof bounds_m);
}

void write_las_point(OutputFile& out, const std::array<std::int32_t, 3>& place, std::uint16_t intensity,
                     double gps_time_s) {
    BinaryRow row;
    for (const std::int32_t x : place) row.add(x);
    row.add(intensity).add(std::uint8_t{0b001'001});  // the first return of one
    row.add(std::uint8_t{0}).add(std::int8_t{0}).add(std::uint8_t{0}).add(std::uint16_t{0});
    row.add(gps_time_s).write(out);
}

LasClock::LasClock(StampNs first_ns) {
    const std::int64_t first_s = first_ns / ns_in_s;
    first_s_ = static_cast<double>(first_s - gps_epoch_s + gps_ahead_of_utc_s(first_ns) - 1'000'000'000) +
               1e-9 * static_cast<double>(first_ns - first_s * ns_in_s);
}

int gps_ahead_of_utc_s(StampNs stamp_ns) {
    // Of each leap second, the first UTC second after it (IERS Bulletin C).
    constexpr std::int64_t after_s[] = {362793600,  394329600,  425865600, 489024000,  567993600,
                                        631152000,  662688000,  709948800, 741484800,  773020800,
                                        820454400,  867715200,  915148800, 1136073600, 1230768000,
                                        1341100800, 1435708800, 1483228800};
    const std::int64_t utc_s = stamp_ns / ns_in_s;
    return static_cast<int>(std::upper_bound(std::begin(after_s), std::end(after_s), utc_s) - after_s);
}

}  // namespace loopline
