#include "output/stored_cloud_files.h"

#include <cmath>

#include "output/binary_row.h"
#include "output/las_format.h"
#include "output/output_file.h"

namespace loopline {
namespace {

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
    BinaryRow row;
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

}  // namespace

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
    LasHeader header;
    header.first_ns = cloud.first_ns;
    header.points = static_cast<std::uint32_t>(cloud.points().size());
    header.unit_m = CloudPoint::unit_m;
    if (!cloud.points().empty())
        for (std::size_t axis = 0; axis < 3; ++axis) {
            header.low_m[static_cast<int>(axis)] = cloud.low()[axis] * CloudPoint::unit_m;
            header.high_m[static_cast<int>(axis)] = cloud.high()[axis] * CloudPoint::unit_m;
        }
    write_las_header(out, header);
    const LasClock clock(cloud.first_ns);
    cloud.points().for_each(0, cloud.points().size(), [&](const CloudPoint& point) {
        write_las_point(out, point.place, point.intensity, clock.seconds(point.time_s()));
    });
    out.commit();
}

}  // namespace loopline
