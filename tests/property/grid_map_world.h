/// Random rooms, scans of them and maps made of these, for tests and benchmarks of the grid map and what is
/// built on it.
#pragma once

#include <random>
#include <utility>
#include <vector>

#include "grid_map/frame.h"
#include "grid_map/scan_grid.h"
#include "property/lines_world.h"

namespace grid_map_world {

using loopline::PlanarScan;
using loopline::Pose2;
using loopline::grid_map::Frame;
using loopline::grid_map::FrameSettings;
using loopline::grid_map::ScanGrid;

struct Sensor {
    std::size_t beams = 541;
    double aperture_rad = 1.5 * M_PI;
    Pose2 T_base_sensor{0.2, 0, 0};
    double sigma_m = 0;
    double max_range_m = 30;
};

template <class Random>
PlanarScan scan_at(const lines_world::World& world, const Pose2& T_world_base, const Sensor& sensor,
                   Random& random) {
    lines_world::Sweep sweep = lines_world::sweep(
        world, {T_world_base * sensor.T_base_sensor, sensor.beams, sensor.aperture_rad, sensor.max_range_m});
    if (sensor.sigma_m > 0) lines_world::add_range_noise(sweep, sensor.sigma_m, random);
    sweep.scan.T_base_sensor = sensor.T_base_sensor;
    return sweep.scan;
}

template <class Random>
Frame frame_at(const lines_world::World& world, const Pose2& T_world_base, const Sensor& sensor,
               Random& random) {
    Frame frame;
    make_frame(scan_at(world, T_world_base, sensor, random), {}, FrameSettings{}, frame);
    return frame;
}

/// Returns anywhere, with and without normals: what no laser would see, but a map must keep all the same.
template <class Random>
Frame random_frame(Random& random, int returns, double reach_m) {
    std::uniform_real_distribution<double> place(-reach_m, reach_m), angle(-M_PI, M_PI);
    Frame frame;
    frame.p_base_sensor_m = Eigen::Vector2d(0.1 * place(random), 0.1 * place(random)).cast<float>();
    for (int i = 0; i < returns; ++i) {
        const double a = angle(random);
        Eigen::Vector2d normal(std::cos(a), std::sin(a));
        if (i % 4 == 0) normal.setZero();
        const Eigen::Vector2d p(place(random), place(random));
        frame.points.push_back({p.cast<float>(), normal.cast<float>()});
    }
    return frame;
}

template <class Random>
Pose2 random_pose(Random& random, double reach_m, double turn_rad = M_PI) {
    std::uniform_real_distribution<double> unit(-1, 1);
    const double x_m = reach_m * unit(random), y_m = reach_m * unit(random);
    return {x_m, y_m, turn_rad * unit(random)};
}

inline void add_box(lines_world::World& world, double x0, double y0, double x1, double y1) {
    const Eigen::Vector2d a(x0, y0), b(x1, y0), c(x1, y1), d(x0, y1);
    world.walls.insert(world.walls.end(), {{a, b}, {b, c}, {c, d}, {d, a}});
}

/// A straight passage along an angle, far longer than any scan reaches.
inline lines_world::World corridor(double width_m, double along_rad) {
    const Pose2 T{0, 0, along_rad};
    lines_world::World world;
    for (const double y : {-width_m / 2, width_m / 2})
        world.walls.push_back({T * Eigen::Vector2d(-200, y), T * Eigen::Vector2d(200, y)});
    return world;
}

}  // namespace grid_map_world
