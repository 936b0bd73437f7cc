/// Single walls seen from near and far, frontal and oblique, with many and few beams: what a line's
/// covariance depends on. Monte Carlo over scans of one such view gives the scatter that the claimed
/// covariance must equal.
#pragma once

#include <cmath>
#include <random>

#include "lines/line_extractor.h"
#include "property/lines_world.h"

namespace lines_world {

struct View {
    const char* name;
    double distance_m, from_m, to_m;  ///< the wall, seen from the sensor: x = distance, y from .. to
    double turn_rad;                  ///< of the sensor
    std::size_t beams;                ///< over 180 degrees
    double sigma_range_m, sigma_bearing_rad, sigma_wall_m;
};

inline constexpr View views[] = {{"near, frontal, many beams", 1.5, -2, 2, 0, 361, 0.01, 0, 0},
                                 {"near, frontal, few beams", 1.5, -0.6, 0.6, 0, 91, 0.01, 0, 0},
                                 {"far, frontal", 12, -4, 4, 0.3, 361, 0.01, 0, 0},
                                 {"far, frontal, few beams", 12, -2, 2, 0, 91, 0.01, 0, 0},
                                 {"near, oblique, many beams", 1, 2, 6, 0.5, 721, 0.01, 0, 0},
                                 {"oblique, few beams", 2, 2, 8, -0.4, 181, 0.01, 0, 0},
                                 {"along a corridor", 1, 0, 12, 0.9, 361, 0.01, 0, 0},
                                 {"coarse sensor", 4, -3, 3, 0.2, 361, 0.05, 0, 0},
                                 {"uneven wall", 3, 0, 4, 0, 361, 0.01, 0, 0.01},
                                 {"beams that point off", 3, 1, 5, 0, 361, 0.005, 0.003, 0},
                                 {"all three", 4, -1, 6, 0, 541, 0.01, 0.002, 0.005}};

struct Scatter {
    int scans = 0, found = 0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();     ///< of the errors of (rho, alpha)
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();  ///< about the truth
    Eigen::Matrix2d claimed = Eigen::Matrix2d::Zero();  ///< mean of the covariances that came with the lines
};

inline double correlation(const Eigen::Matrix2d& c) {
    return c(0, 1) / std::sqrt(c(0, 0) * c(1, 1));
}

/// Many noisy scans of a view; those in which not exactly one line was found don't count as found.
inline Scatter monte_carlo(const View& view, loopline::lines::Method method, int scans) {
    World world;
    world.walls.push_back({{view.distance_m, view.from_m}, {view.distance_m, view.to_m}});
    Sensor sensor;
    sensor.beams = view.beams;
    sensor.T_world_sensor.phi_rad = view.turn_rad;
    const TrueLine truth = true_line(world.walls[0], sensor.T_world_sensor);
    const Sweep exact = sweep(world, sensor);

    loopline::lines::ExtractionParameters parameters;
    parameters.method = method;
    parameters.sigma_range_m = view.sigma_range_m;
    parameters.sigma_bearing_rad = view.sigma_bearing_rad;
    parameters.sigma_wall_m = view.sigma_wall_m;
    const auto extractor = loopline::lines::make_line_extractor(parameters);

    Scatter result;
    result.scans = scans;
    std::mt19937_64 random(20);
    std::normal_distribution<double> unit(0, 1);
    loopline::PlanarScan scan = exact.scan;
    loopline::lines::LineSegments segments;
    for (int k = 0; k < scans; ++k) {
        for (std::size_t i = 0; i < scan.size(); ++i) {
            if (exact.wall[i] != 0) continue;
            // A beam that points off by b and meets a wall that stands out by u.
            const double incidence =
                scan.angle_rad(i) + view.sigma_bearing_rad * unit(random) - truth.alpha_rad;
            const double range = (truth.rho_m + view.sigma_wall_m * unit(random)) / std::cos(incidence);
            scan.ranges_m[i] = static_cast<float>(range + view.sigma_range_m * unit(random));
        }
        extractor->extract(scan, segments);
        if (segments.size() != 1) continue;
        ++result.found;
        const Eigen::Vector2d error(segments[0].rho_m - truth.rho_m,
                                    loopline::wrap_to_pi(segments[0].alpha_rad - truth.alpha_rad));
        result.mean += error;
        result.scatter += error * error.transpose();
        result.claimed += segments[0].covariance;
    }
    result.mean /= result.found;
    result.scatter /= result.found;
    result.claimed /= result.found;
    return result;
}

}  // namespace lines_world
