/// Random polygon worlds with truth, for tests and benchmarks of line extraction: exact ranges by brute force
/// over all walls, and for every beam which wall it met.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "api/planar_scan.h"
#include "lines/line_segment.h"

namespace lines_world {

struct Wall {
    Eigen::Vector2d a_m, b_m;
};
/// Pillar or round wall, seen from outside or inside.
struct Circle {
    Eigen::Vector2d centre_m;
    double radius_m;
};
struct World {
    std::vector<Wall> walls;
    std::vector<Circle> circles;
};

struct Sensor {
    loopline::Pose2 T_world_sensor;
    std::size_t beams = 181;
    double aperture_rad = M_PI;
    double max_range_m = 80;
};

/// A scan and, per beam, the wall it met (-1: none or a circle).
struct Sweep {
    loopline::PlanarScan scan;
    std::vector<int> wall;
    std::vector<double> exact_range_m;
};

inline double range_to(const Wall& wall, const Eigen::Vector2d& origin, const Eigen::Vector2d& beam) {
    const Eigen::Vector2d along = wall.b_m - wall.a_m, to = wall.a_m - origin;
    const double cross = beam.x() * along.y() - beam.y() * along.x();
    if (std::abs(cross) < 1e-12) return INFINITY;
    const double range = (to.x() * along.y() - to.y() * along.x()) / cross;
    const double u = (to.x() * beam.y() - to.y() * beam.x()) / cross;
    return range > 0 && u >= 0 && u <= 1 ? range : INFINITY;
}

inline double range_to(const Circle& circle, const Eigen::Vector2d& origin, const Eigen::Vector2d& beam) {
    const Eigen::Vector2d to = circle.centre_m - origin;
    const double middle = to.dot(beam),
                 rest = circle.radius_m * circle.radius_m - to.squaredNorm() + middle * middle;
    if (rest < 0) return INFINITY;
    const double near = middle - std::sqrt(rest), far = middle + std::sqrt(rest);
    return near > 0 ? near : far > 0 ? far : INFINITY;
}

/// Noise-free sweep.
inline Sweep sweep(const World& world, const Sensor& sensor) {
    Sweep result;
    auto& scan = result.scan;
    scan.angle_step_rad = sensor.aperture_rad / static_cast<double>(sensor.beams - 1);
    scan.first_angle_rad = -0.5 * sensor.aperture_rad;
    scan.max_range_m = sensor.max_range_m;
    scan.ranges_m.assign(sensor.beams, 0);
    result.wall.assign(sensor.beams, -1);
    result.exact_range_m.assign(sensor.beams, 0);
    for (std::size_t i = 0; i < sensor.beams; ++i) {
        const double bearing = sensor.T_world_sensor.phi_rad + scan.angle_rad(i);
        const Eigen::Vector2d beam(std::cos(bearing), std::sin(bearing));
        double nearest = INFINITY;
        for (std::size_t w = 0; w < world.walls.size(); ++w) {
            const double range = range_to(world.walls[w], sensor.T_world_sensor.translation(), beam);
            if (range < nearest) {
                nearest = range;
                result.wall[i] = static_cast<int>(w);
            }
        }
        for (const auto& circle : world.circles) {
            const double range = range_to(circle, sensor.T_world_sensor.translation(), beam);
            if (range < nearest) {
                nearest = range;
                result.wall[i] = -1;
            }
        }
        if (nearest >= sensor.max_range_m) {
            result.wall[i] = -1;
            continue;
        }
        result.exact_range_m[i] = nearest;
        scan.ranges_m[i] = static_cast<float>(nearest);
    }
    return result;
}

/// Range noise along the beam; a return that it makes unusable is none.
template <class Random>
void add_range_noise(Sweep& sweep, double sigma_m, Random& random) {
    std::normal_distribution<double> noise(0, sigma_m);
    for (auto& range : sweep.scan.ranges_m)
        if (range > 0) {
            range = static_cast<float>(range + noise(random));
            if (!(range > 0.01f)) range = 0;
        }
    sweep.scan.sigma_range_m = sigma_m;
}

/// A wall's line in the sensor's frame: rho >= 0, alpha in (-pi, pi].
struct TrueLine {
    double rho_m, alpha_rad;
};
inline TrueLine true_line(const Wall& wall, const loopline::Pose2& T_world_sensor) {
    const loopline::Pose2 T_sensor_world = T_world_sensor.inverse();
    const Eigen::Vector2d a = T_sensor_world * wall.a_m, b = T_sensor_world * wall.b_m;
    const Eigen::Vector2d along = (b - a).normalized();
    Eigen::Vector2d normal(-along.y(), along.x());
    double rho = normal.dot(a);
    if (rho < 0) {
        rho = -rho;
        normal = -normal;
    }
    return {rho, std::atan2(normal.y(), normal.x())};
}

/// A room around the origin with `corners` walls meeting at random angles, and a few boxes standing in it.
template <class Random>
World random_world(Random& random, int corners, int boxes) {
    std::uniform_real_distribution<double> unit(0, 1);
    World world;
    std::vector<Eigen::Vector2d> outline;
    for (int i = 0; i < corners; ++i) {
        const double bearing = 2 * M_PI * (i + 0.7 * (unit(random) - 0.5)) / corners,
                     r = 4 + 8 * unit(random);
        outline.emplace_back(r * std::cos(bearing), r * std::sin(bearing));
    }
    for (std::size_t i = 0; i < outline.size(); ++i)
        world.walls.push_back({outline[i], outline[(i + 1) % outline.size()]});
    for (int k = 0; k < boxes; ++k) {
        const double bearing = 2 * M_PI * unit(random), r = 2 + 2 * unit(random),
                     turn = 2 * M_PI * unit(random);
        const double w = 0.3 + 0.9 * unit(random), h = 0.3 + 0.9 * unit(random);
        const loopline::Pose2 T{r * std::cos(bearing), r * std::sin(bearing), turn};
        const Eigen::Vector2d c[4] = {T * Eigen::Vector2d(-w, -h), T * Eigen::Vector2d(w, -h),
                                      T * Eigen::Vector2d(w, h), T * Eigen::Vector2d(-w, h)};
        for (int i = 0; i < 4; ++i) world.walls.push_back({c[i], c[(i + 1) % 4]});
    }
    return world;
}

}  // namespace lines_world
