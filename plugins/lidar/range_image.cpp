#include "lidar/range_image.h"

#include <cmath>

#include "lidar/beam_table.h"

namespace loopline::lidar {

bool same(const RangeImageGeometry& a, const RangeImageGeometry& b) {
    return a.columns == b.columns && a.first_azimuth_rad == b.first_azimuth_rad &&
           a.azimuth_span_rad == b.azimuth_span_rad && a.sweep_s == b.sweep_s &&
           a.range_unit_m == b.range_unit_m && a.elevations_deg == b.elevations_deg;
}

void RangeImageReader::prepare(const RangeImageGeometry& geometry) {
    geometry_ = geometry;
    columns_.clear();
    for (int k = 0; k < geometry.columns; ++k) {
        const double a_rad = geometry.azimuth_rad(k);
        columns_.push_back({static_cast<float>(std::cos(a_rad)), static_cast<float>(std::sin(a_rad)),
                            static_cast<float>(geometry.time_s(k))});
    }
    rows_.clear();
    for (const int row : from_high_to_low(geometry.elevations_deg)) {
        const double e_rad = geometry.elevations_deg[static_cast<std::size_t>(row)] * M_PI / 180;
        rows_.push_back({static_cast<std::size_t>(row),
                         static_cast<float>(geometry.range_unit_m * std::cos(e_rad)),
                         static_cast<float>(geometry.range_unit_m * std::sin(e_rad))});
    }
}

void RangeImageReader::read(const RangeImageGeometry& geometry, const std::uint16_t* ranges,
                            std::size_t stride, SpinningScan& scan) {
    if (!same(geometry, geometry_)) prepare(geometry);
    const std::size_t columns = columns_.size();
    scan.points.resize(rows_.size() * columns);
    scan.ring_begin.clear();
    SpinningPoint* next = scan.points.data();
    for (const Row& row : rows_) {
        scan.ring_begin.push_back(static_cast<std::uint32_t>(next - scan.points.data()));
        const std::uint16_t* const in_row = ranges + row.row * stride;
        for (std::size_t k = 0; k < columns; ++k) {
            if (in_row[k] == 0) continue;
            const auto range = static_cast<float>(in_row[k]);
            const Column& column = columns_[k];
            const float level_m = range * row.cosine_m;
            *next++ = {level_m * column.cosine, level_m * column.sine, range * row.sine_m, column.time_s};
        }
    }
    scan.points.resize(static_cast<std::size_t>(next - scan.points.data()));
    scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
    scan.begin_s = 0;
    scan.end_s = geometry.sweep_s;
}

}  // namespace loopline::lidar
