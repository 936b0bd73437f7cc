/// What a spinning lidar sees of rectangles in space, each beam from where it is at its time.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "api/pose3_motion.h"
#include "lidar/spinning_scan.h"

namespace loopline::test {

/// A rectangle: corner, and its two edges, at right angles.
struct Rectangle {
    Eigen::Vector3d corner_m, edge_a_m, edge_b_m;
};

struct SpinningBeams {
    int rings = 32, columns = 900;
    double highest_rad = 0.18, lowest_rad = -0.5;
    double sweep_s = 0.1;
    double sigma_range_m = 0;
};

/// Where a ray meets a rectangle, in parts of its direction; 0: nowhere.
inline double meets(const Rectangle& r, const Eigen::Vector3d& from_m, const Eigen::Vector3d& along) {
    const Eigen::Vector3d n = r.edge_a_m.cross(r.edge_b_m);
    const double slope = n.dot(along);
    if (std::abs(slope) < 1e-12) return 0;
    const double range = n.dot(r.corner_m - from_m) / slope;
    if (!(range > 0)) return 0;
    const Eigen::Vector3d at_m = from_m + range * along - r.corner_m;
    const double a = at_m.dot(r.edge_a_m) / r.edge_a_m.squaredNorm(),
                 b = at_m.dot(r.edge_b_m) / r.edge_b_m.squaredNorm();
    return a >= 0 && a <= 1 && b >= 0 && b <= 1 ? range : 0;
}

/// A sweep of 0.1 s about `stamp_ns`, its middle; clockwise from behind. `T_map_lidar`: at a time after the
/// middle.
inline lidar::SpinningScan sweep_in(const std::vector<Rectangle>& world,
                                    const std::function<Pose3(double)>& T_map_lidar, StampNs stamp_ns,
                                    const SpinningBeams& beams, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    lidar::SpinningScan scan;
    scan.stamp_ns = stamp_ns;
    scan.begin_s = -beams.sweep_s / 2;
    scan.end_s = beams.sweep_s / 2;
    std::vector<Pose3> poses;
    for (int k = 0; k < beams.columns; ++k)
        poses.push_back(T_map_lidar(beams.sweep_s * (k / double(beams.columns - 1) - 0.5)));
    for (int ring = 0; ring < beams.rings; ++ring) {
        scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
        const double e_rad =
            beams.highest_rad + (beams.lowest_rad - beams.highest_rad) * ring / (beams.rings - 1);
        for (int k = 0; k < beams.columns; ++k) {
            const double a_rad = M_PI - 2 * M_PI * k / beams.columns;
            const Eigen::Vector3d beam(std::cos(e_rad) * std::cos(a_rad), std::cos(e_rad) * std::sin(a_rad),
                                       std::sin(e_rad));
            const auto& T = poses[static_cast<std::size_t>(k)];
            const Eigen::Vector3d along = T.rotation * beam;
            double range_m = 0;
            for (const Rectangle& r : world) {
                const double met_m = meets(r, T.translation_m, along);
                if (met_m > 0 && (range_m == 0 || met_m < range_m)) range_m = met_m;
            }
            if (range_m == 0 || range_m > 100) continue;
            const Eigen::Vector3d p = (range_m + beams.sigma_range_m * normal(random)) * beam;
            scan.points.push_back(
                {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
                 static_cast<float>(beams.sweep_s * (k / double(beams.columns - 1) - 0.5))});
        }
    }
    scan.ring_begin.push_back(static_cast<std::uint32_t>(scan.points.size()));
    return scan;
}

/// Four upright sides.
inline void add_box(std::vector<Rectangle>& world, double x_m, double y_m, double length_m, double width_m,
                    double height_m) {
    const Eigen::Vector3d corner(x_m, y_m, 0), a(length_m, 0, 0), b(0, width_m, 0), up(0, 0, height_m);
    for (const Rectangle& side : {Rectangle{corner, a, up}, Rectangle{corner, b, up},
                                  Rectangle{corner + b, a, up}, Rectangle{corner + a, b, up}})
        world.push_back(side);
}

/// 60 m x 40 m with walls, a floor, houses and pillars.
inline std::vector<Rectangle> walled_yard() {
    std::vector<Rectangle> world{{{-30, -20, 0}, {60, 0, 0}, {0, 40, 0}}};
    add_box(world, -30, -20, 60, 40, 8);
    add_box(world, 8, 6, 6, 5, 5);
    add_box(world, -15, 8, 4, 7, 6);
    add_box(world, -10, -14, 9, 4, 4);
    for (const double x_m : {-20.0, -4.0, 5.0, 15.0, 22.0}) {
        add_box(world, x_m, 3, 0.4, 0.4, 5);
        add_box(world, x_m + 2, -6, 0.4, 0.4, 5);
    }
    return world;
}

/// A floor and two walls without end, for a lidar 100 m far.
inline std::vector<Rectangle> endless_corridor() {
    return {{{-400, -4, 0}, {800, 0, 0}, {0, 8, 0}},
            {{-400, -4, 0}, {800, 0, 0}, {0, 0, 4}},
            {{-400, 4, 0}, {800, 0, 0}, {0, 0, 4}}};
}

}  // namespace loopline::test
