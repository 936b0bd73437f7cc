#include "output/utm_las.h"

#include <algorithm>
#include <cmath>

#include "gnss/utm_of_map.h"
#include "output/las_format.h"
#include "output/output_file.h"

namespace loopline {
namespace {

/// Whole numbers of 32 bits reach 214 km in steps of 0.1 mm; the grid's lengths differ by a thousandth.
constexpr double reach_of_fine_unit_m = 200e3;

LasCoordinateSystem system_of(const gnss::Utm& grid) {
    return {gnss::epsg_code(grid), "WGS 84 / UTM zone " + std::to_string(grid.zone) +
                                       (grid.north ? "N" : "S") + "; heights above the ellipsoid"};
}

bool is_finite_point(float x, float y, float z) {
    return std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
}

}  // namespace

PointsOnMap points_on_map(const StoredCloud& cloud) {
    PointsOnMap points;
    points.count = cloud.points().size();
    points.first_ns = cloud.first_ns;
    if (points.count > 0)
        for (const auto& corner : {cloud.low(), cloud.high()})
            for (const std::int32_t x : corner)
                points.reach_m = std::max(points.reach_m, std::abs(x * CloudPoint::unit_m));
    points.for_each = [&cloud](const auto& use) {
        cloud.points().for_each(0, cloud.points().size(), [&use](const CloudPoint& point) {
            use({point.p_map_m(), point.intensity, point.time_s()});
        });
    };
    return points;
}

PointsOnMap points_on_map(const mrpt::maps::CPointsMap& map, StampNs first_ns) {
    PointsOnMap points;
    points.first_ns = first_ns;
    points.for_each = [&map](const auto& use) {
        const auto &x = map.getPointsBufferRef_x(), &y = map.getPointsBufferRef_y(),
                   &z = map.getPointsBufferRef_z();
        for (std::size_t i = 0; i < x.size(); ++i)
            if (is_finite_point(x[i], y[i], z[i])) use({{x[i], y[i], z[i]}, 0, 0});
    };
    points.for_each([&points](const LasPointOnMap& point) {
        ++points.count;
        points.reach_m = std::max(points.reach_m, point.p_map_m.cwiseAbs().maxCoeff());
    });
    return points;
}

std::optional<gnss::Utm> grid_of(const gnss::GeoReference& reference) {
    return gnss::to_utm(reference.origin());
}

void write_utm_las(const std::filesystem::path& file, const PointsOnMap& points,
                   const gnss::GeoReference& reference, const gnss::Utm& grid) {
    OutputFile out(file);
    const LasCoordinateSystem system = system_of(grid);
    LasHeader header;
    header.first_ns = points.first_ns;
    header.points = static_cast<std::uint32_t>(points.count);
    header.unit_m = points.reach_m < reach_of_fine_unit_m ? 1e-4 : 1e-3;
    header.offset_m = {std::round(grid.easting_m), std::round(grid.northing_m), 0};
    header.system = &system;
    write_las_header(out, header);
    const LasClock clock(points.first_ns);
    gnss::UtmOfMap on_utm(reference, grid);
    using Place = Eigen::Array<double, 3, 1>;
    Place low = Place::Constant(INFINITY), high = -low;  // in units
    points.for_each([&](const LasPointOnMap& point) {
        const Place units =
            ((on_utm.p_utm_m(point.p_map_m) - header.offset_m).array() / header.unit_m).round();
        low = low.min(units);
        high = high.max(units);
        write_las_point(out,
                        {static_cast<std::int32_t>(units[0]), static_cast<std::int32_t>(units[1]),
                         static_cast<std::int32_t>(units[2])},
                        point.intensity, clock.seconds(point.after_first_s));
    });
    if (points.count > 0)
        overwrite_las_bounds(out, header.offset_m + header.unit_m * low.matrix(),
                             header.offset_m + header.unit_m * high.matrix());
    out.commit();
}

}  // namespace loopline
