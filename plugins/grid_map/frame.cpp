#include "grid_map/frame.h"

#include <algorithm>
#include <cmath>

namespace loopline::grid_map {
namespace {

/// Sums over the points of a chain up to each of them, so that any part of it is fitted by two differences.
struct Sums {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    void add(const Eigen::Vector2d& p) {
        n += 1;
        x += p.x();
        y += p.y();
        xx += p.x() * p.x();
        xy += p.x() * p.y();
        yy += p.y() * p.y();
    }
    Sums operator-(const Sums& o) const {
        return {n - o.n, x - o.x, y - o.y, xx - o.xx, xy - o.xy, yy - o.yy};
    }
};

struct FittedSurface {
    Eigen::Vector2d mean_m, normal;  ///< towards the origin; zero if there is none
};

/// The line of least squares through the points; none if they scatter too much about it, or are too close
/// together to tell.
FittedSurface surface_through(const Sums& s, double sigma_max_m) {
    const double mx = s.x / s.n, my = s.y / s.n;
    const double cxx = s.xx / s.n - mx * mx, cxy = s.xy / s.n - mx * my, cyy = s.yy / s.n - my * my;
    const double mean = (cxx + cyy) / 2, spread = std::hypot((cxx - cyy) / 2, cxy);
    const double across = std::max(0.0, mean - spread), along = mean + spread;
    if (across > sigma_max_m * sigma_max_m || across > 0.2 * along || along <= 0)
        return {{mx, my}, Eigen::Vector2d::Zero()};
    const double direction_rad = 0.5 * std::atan2(2 * cxy, cxx - cyy);
    Eigen::Vector2d normal(-std::sin(direction_rad), std::cos(direction_rad));
    if (normal.x() * mx + normal.y() * my > 0) normal = -normal;
    return {{mx, my}, normal};
}

/// Whether two returns next to each other can be of one surface: as far apart as a surface at 15 degrees to
/// the beams would set them, or closer.
bool joined(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double angle_rad) {
    const double nearer_m = std::min(a.norm(), b.norm());
    const double most_m = 0.1 + 4 * nearer_m * angle_rad;
    return (a - b).squaredNorm() < most_m * most_m;
}

}  // namespace

void make_frame(const PlanarScan& scan, const SweepMotion& motion, const FrameSettings& settings,
                Frame& frame) {
    frame.points.clear();
    const double c = std::cos(scan.T_base_sensor.phi_rad), s = std::sin(scan.T_base_sensor.phi_rad);
    frame.p_base_sensor_m = scan.T_base_sensor.translation().cast<float>();
    // In the sensor's frame at the first beam: what the vehicle moves, and what its turn moves the sensor.
    const Eigen::Vector2d drift_base_m(motion.forward_m - motion.turn_rad * scan.T_base_sensor.y_m,
                                       motion.left_m + motion.turn_rad * scan.T_base_sensor.x_m);
    const Eigen::Vector2d drift_m(c * drift_base_m.x() + s * drift_base_m.y(),
                                  -s * drift_base_m.x() + c * drift_base_m.y());
    const bool moves = drift_m.squaredNorm() > 0 || motion.turn_rad != 0;
    const double per_beam = scan.size() > 1 ? 1 / static_cast<double>(scan.size() - 1) : 0;

    thread_local std::vector<Eigen::Vector2d> points;  // sensor frame at the first beam
    thread_local std::vector<std::size_t> beams, chain_begin, chain_end;
    thread_local std::vector<Sums> sums;  // up to and without each point
    points.clear();
    beams.clear();
    for (std::size_t beam = 0; beam < scan.size(); ++beam) {
        if (!scan.has_return(beam)) continue;
        const double range_m = scan.ranges_m[beam];
        if (range_m < settings.min_range_m || range_m > settings.max_range_m) continue;
        points.push_back(scan.point_sensor_m(beam));
        if (moves) {
            // A sweep is short: its arc is its chord.
            const double part = static_cast<double>(beam) * per_beam, turn = motion.turn_rad * part;
            const Eigen::Vector2d p = points.back();
            points.back() = Eigen::Vector2d(p.x() - turn * p.y() - 0.5 * turn * turn * p.x(),
                                            p.y() + turn * p.x() - 0.5 * turn * turn * p.y()) +
                            drift_m * part;
        }
        beams.push_back(beam);
    }
    const std::size_t n = points.size();
    sums.assign(n + 1, {});
    chain_begin.assign(n, 0);
    chain_end.assign(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
        sums[i + 1] = sums[i];
        sums[i + 1].add(points[i]);
        const bool joins = i > 0 && beams[i] - beams[i - 1] <= 2 &&
                           joined(points[i - 1], points[i],
                                  static_cast<double>(beams[i] - beams[i - 1]) * scan.angle_step_rad);
        chain_begin[i] = joins ? chain_begin[i - 1] : i;
    }
    for (std::size_t i = n; i-- > 0;)
        chain_end[i] = i + 1 < n && chain_begin[i + 1] == chain_begin[i] ? chain_end[i + 1] : i + 1;

    frame.points.reserve(n);
    const double half2_m2 = settings.surface_half_m * settings.surface_half_m,
                 spacing2_m2 = settings.spacing_m * settings.spacing_m;
    Eigen::Vector2d kept = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
        // At least one neighbour to each side if there is one, more as long as they are close.
        std::size_t from = i, to = i + 1;
        while (from > chain_begin[i] &&
               (i - from < 1 || (points[from - 1] - points[i]).squaredNorm() < half2_m2))
            --from;
        while (to < chain_end[i] && (to - i < 2 || (points[to] - points[i]).squaredNorm() < half2_m2)) ++to;
        FittedSurface surface{points[i], Eigen::Vector2d::Zero()};
        if (to - from >= 3) surface = surface_through(sums[to] - sums[from], settings.sigma_surface_m);
        const Eigen::Vector2d &normal = surface.normal,
                              p = points[i] + normal.dot(surface.mean_m - points[i]) * normal;
        if (i > chain_begin[i] && (points[i] - kept).squaredNorm() < spacing2_m2) continue;
        kept = points[i];
        frame.points.push_back(
            {Eigen::Vector2f(static_cast<float>(scan.T_base_sensor.x_m + c * p.x() - s * p.y()),
                             static_cast<float>(scan.T_base_sensor.y_m + s * p.x() + c * p.y())),
             Eigen::Vector2f(static_cast<float>(c * normal.x() - s * normal.y()),
                             static_cast<float>(s * normal.x() + c * normal.y()))});
    }
}

}  // namespace loopline::grid_map
