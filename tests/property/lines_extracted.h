/// What the tests of line extraction share: extractors, scans of random worlds, and lines compared.
#pragma once

#include <cmath>
#include <memory>
#include <random>

#include "api/dense_algebra.h"
#include "lines/line_extractor.h"
#include "property/lines_world.h"

namespace lines_world {

using namespace loopline;
using namespace loopline::lines;

inline constexpr Method all_methods[] = {Method::angle_threshold, Method::split_and_merge,
                                         Method::incremental};

inline std::unique_ptr<LineExtractor> extractor_of(Method method) {
    ExtractionParameters parameters;
    parameters.method = method;
    parameters.sigma_wall_m = 0;
    return make_line_extractor(parameters);
}

inline LineSegments lines_of(LineExtractor& extractor, const PlanarScan& scan) {
    LineSegments segments;
    extractor.extract(scan, segments);
    return segments;
}

/// World k of a series, seen from a random place near its middle.
inline Sweep random_sweep(int k, double sigma_m, std::mt19937_64& random, World& world, Sensor& sensor) {
    std::uniform_real_distribution<double> unit(0, 1);
    world = random_world(random, 4 + k % 5, k % 4);
    sensor.beams = k % 2 ? 181 : 361;
    sensor.T_world_sensor = {0.5 * unit(random), 0.5 * unit(random), 2 * M_PI * unit(random)};
    Sweep sweep = lines_world::sweep(world, sensor);
    add_range_noise(sweep, sigma_m, random);
    return sweep;
}

/// The line of `segments` nearest to `line`, in the line's sigmas; infinite if none points the same way.
inline double nearest_in_sigmas(const LineSegment& line, const LineSegments& segments) {
    double nearest = INFINITY;
    for (const auto& s : segments) {
        const Eigen::Vector2d d(s.rho_m - line.rho_m, wrap_to_pi(s.alpha_rad - line.alpha_rad));
        if (std::abs(d(1)) > 0.2 || (s.start_m - line.start_m).norm() > line.length_m()) continue;
        nearest = std::min(nearest, std::sqrt(squared_in_sigmas(d, line.covariance)));
    }
    return nearest;
}

inline PlanarScan uniform_scan(std::size_t beams, double sweep_rad, float range_m) {
    PlanarScan scan;
    scan.first_angle_rad = -sweep_rad / 2;
    scan.angle_step_rad = beams > 1 ? sweep_rad / static_cast<double>(beams - 1) : 0.01;
    scan.max_range_m = 80;
    scan.ranges_m.assign(beams, range_m);
    return scan;
}

}  // namespace lines_world
