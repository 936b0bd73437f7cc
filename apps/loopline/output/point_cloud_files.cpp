#include "output/point_cloud_files.h"

#include <array>
#include <cmath>

#include "output/output_file.h"

namespace loopline {
namespace {

using mrpt::maps::CPointsMap;

template <class Use>
void for_each_finite_point(const CPointsMap& points, Use use) {
    const auto& x = points.getPointsBufferRef_x();
    const auto& y = points.getPointsBufferRef_y();
    const auto& z = points.getPointsBufferRef_z();
    for (std::size_t i = 0; i < x.size(); ++i)
        if (std::isfinite(x[i]) && std::isfinite(y[i]) && std::isfinite(z[i]))
            use(std::array<float, 3>{x[i], y[i], z[i]});
}

std::size_t finite_points(const CPointsMap& points) {
    std::size_t count = 0;
    for_each_finite_point(points, [&count](const auto&) { ++count; });
    return count;
}

void write_points(OutputFile& out, const CPointsMap& points) {
    static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "swap the bytes here on a big-endian machine");
    for_each_finite_point(points, [&out](const std::array<float, 3>& p) { out.bytes(p.data(), sizeof p); });
}

}  // namespace

std::size_t write_ply(const std::filesystem::path& file, const CPointsMap& points) {
    const std::size_t count = finite_points(points);
    OutputFile out(file);
    out.text("ply\nformat binary_little_endian 1.0\ncomment metres, local map frame\nelement vertex ")
        .count(count);
    out.text("\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
    write_points(out, points);
    out.commit();
    return points.size() - count;
}

std::size_t write_pcd(const std::filesystem::path& file, const CPointsMap& points) {
    const std::size_t count = finite_points(points);
    OutputFile out(file);
    out.text("# .PCD v0.7 - metres, local map frame\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n");
    out.text("COUNT 1 1 1\nWIDTH ")
        .count(count)
        .text("\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ")
        .count(count);
    out.text("\nDATA binary\n");
    write_points(out, points);
    out.commit();
    return points.size() - count;
}

}  // namespace loopline
