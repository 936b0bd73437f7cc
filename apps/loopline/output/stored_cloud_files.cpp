#include "output/stored_cloud_files.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>

#include "output/output_file.h"

namespace loopline {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "swap the bytes here on a big-endian machine");

/// Numbers one behind the other, as they lie in a file.
class Row {
 public:
    template <class T>
    Row& add(T value) {
        std::memcpy(bytes_ + size_, &value, sizeof value);
        size_ += sizeof value;
        return *this;
    }
    void write(OutputFile& out) {
        out.bytes(bytes_, size_);
        size_ = 0;
    }

 private:
    char bytes_[64];
    std::size_t size_ = 0;
};

bool needs_double(const StoredCloud& cloud) {
    constexpr double float_reach_m = 4096;  // beyond, neighbouring floats are half a millimetre apart
    if (cloud.points().empty()) return false;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const auto& corner : {cloud.low(), cloud.high()})
            if (std::abs(corner[axis] * CloudPoint::unit_m) > float_reach_m) return true;
    return false;
}

void write_rows(OutputFile& out, const StoredCloud& cloud) {
    const bool as_double = needs_double(cloud);
    Row row;
    cloud.points().for_each(0, cloud.points().size(), [&](const CloudPoint& point) {
        for (const std::int32_t x : point.place) {
            if (as_double)
                row.add(x * CloudPoint::unit_m);
            else
                row.add(static_cast<float>(x * CloudPoint::unit_m));
        }
        if (cloud.has_intensity) row.add(static_cast<float>(point.intensity / 65535.0));
        row.add(static_cast<float>(point.time_s()));
        row.write(out);
    });
}

constexpr std::int64_t ns_in_s = 1'000'000'000;
constexpr std::int64_t gps_epoch_s = 315'964'800;  ///< 1980-01-06, of UTC

void write_text(OutputFile& out, const char* text, std::size_t width) {
    std::string padded(text);
    padded.resize(width, '\0');
    out.text(padded);
}

/// Day of the year from 1, and year, of a stamp: the file says nothing of when it was written, so that the
/// same run gives the same bytes.
std::pair<std::uint16_t, std::uint16_t> date_of(StampNs stamp_ns) {
    const std::time_t seconds = stamp_ns / ns_in_s;
    std::tm date{};
    gmtime_r(&seconds, &date);
    return {static_cast<std::uint16_t>(date.tm_yday + 1), static_cast<std::uint16_t>(date.tm_year + 1900)};
}

constexpr std::uint16_t las_header_bytes = 227, las_point_bytes = 28;

void write_las_header(OutputFile& out, const StoredCloud& cloud) {
    const auto points = static_cast<std::uint32_t>(cloud.points().size());
    const auto [day, year] = date_of(cloud.first_ns);
    Row row;
    out.text("LASF");
    row.add(std::uint16_t{0}).add(std::uint16_t{1}).write(out);  // source; time is GPS time less 1e9 s
    write_text(out, "", 16);                                     // project
    row.add(std::uint8_t{1}).add(std::uint8_t{2}).write(out);
    write_text(out, "EXTRACTION", 32);
    write_text(out, "Loopline", 32);
    row.add(day).add(year).add(las_header_bytes).add(std::uint32_t{las_header_bytes}).add(std::uint32_t{0});
    row.add(std::uint8_t{1}).add(las_point_bytes).add(points).write(out);
    row.add(points).write(out);  // by number of return: each is the first of one
    for (int i = 1; i < 5; ++i) row.add(std::uint32_t{0}).write(out);
    for (int axis = 0; axis < 3; ++axis) row.add(CloudPoint::unit_m).write(out);
    for (int axis = 0; axis < 3; ++axis) row.add(0.0).write(out);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool none = cloud.points().empty();
        row.add(none ? 0.0 : cloud.high()[axis] * CloudPoint::unit_m);
        row.add(none ? 0.0 : cloud.low()[axis] * CloudPoint::unit_m).write(out);
    }
}

}  // namespace

int gps_ahead_of_utc_s(StampNs stamp_ns) {
    // Of each leap second, the first UTC second after it (IERS Bulletin C).
    constexpr std::int64_t after_s[] = {362793600,  394329600,  425865600, 489024000,  567993600,
                                        631152000,  662688000,  709948800, 741484800,  773020800,
                                        820454400,  867715200,  915148800, 1136073600, 1230768000,
                                        1341100800, 1435708800, 1483228800};
    const std::int64_t utc_s = stamp_ns / ns_in_s;
    return static_cast<int>(std::upper_bound(std::begin(after_s), std::end(after_s), utc_s) - after_s);
}

void write_ply(const std::filesystem::path& file, const StoredCloud& cloud) {
    OutputFile out(file);
    const char* real = needs_double(cloud) ? "double" : "float";
    out.text("ply\nformat binary_little_endian 1.0\ncomment metres, map frame; time_s counts from UTC ")
        .seconds(cloud.first_ns)
        .text("\nelement vertex ")
        .count(cloud.points().size());
    for (const char* axis : {"x", "y", "z"}) out.text("\nproperty ").text(real).character(' ').text(axis);
    if (cloud.has_intensity) out.text("\nproperty float intensity");
    out.text("\nproperty float time_s\nend_header\n");
    write_rows(out, cloud);
    out.commit();
}

void write_pcd(const std::filesystem::path& file, const StoredCloud& cloud) {
    OutputFile out(file);
    const std::string real = needs_double(cloud) ? "8" : "4", size = real + " " + real + " " + real;
    const bool more = cloud.has_intensity;
    out.text("# .PCD v0.7 - metres, map frame; time_s counts from UTC ").seconds(cloud.first_ns);
    out.text("\nVERSION 0.7\nFIELDS x y z ").text(more ? "intensity time_s" : "time_s");
    out.text("\nSIZE ").text(size).text(more ? " 4 4" : " 4");
    out.text("\nTYPE F F F").text(more ? " F F" : " F").text("\nCOUNT 1 1 1").text(more ? " 1 1" : " 1");
    out.text("\nWIDTH ").count(cloud.points().size()).text("\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ");
    out.count(cloud.points().size()).text("\nDATA binary\n");
    write_rows(out, cloud);
    out.commit();
}

void write_las(const std::filesystem::path& file, const StoredCloud& cloud) {
    OutputFile out(file);
    write_las_header(out, cloud);
    const std::int64_t first_s = cloud.first_ns / ns_in_s;
    const double seconds_of_first =
        static_cast<double>(first_s - gps_epoch_s + gps_ahead_of_utc_s(cloud.first_ns) - 1'000'000'000) +
        1e-9 * static_cast<double>(cloud.first_ns - first_s * ns_in_s);
    Row row;
    cloud.points().for_each(0, cloud.points().size(), [&](const CloudPoint& point) {
        for (const std::int32_t x : point.place) row.add(x);
        row.add(point.intensity).add(std::uint8_t{0b001'001});  // the first return of one
        row.add(std::uint8_t{0}).add(std::int8_t{0}).add(std::uint8_t{0}).add(std::uint16_t{0});
        row.add(seconds_of_first + point.time_s()).write(out);
    });
    out.commit();
}

}  // namespace loopline
