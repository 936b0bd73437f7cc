/// Returns with the surfaces that they lie on: normals, corners, spacing, and sweeps of a moving sensor.
#include <gtest/gtest.h>

#include "property/grid_map_world.h"

using namespace loopline::grid_map;
using grid_map_world::Sensor;
using loopline::Pose2;

namespace {

/// Direction of the normal of a wall, as seen from a place.
Eigen::Vector2d normal_towards(const lines_world::Wall& wall, const Eigen::Vector2d& from_m) {
    const Eigen::Vector2d along = (wall.b_m - wall.a_m).normalized(), normal(-along.y(), along.x());
    return normal.dot(from_m - wall.a_m) > 0 ? normal : Eigen::Vector2d(-normal);
}

double distance_m(const lines_world::Wall& wall, const Eigen::Vector2d& p) {
    const Eigen::Vector2d along = wall.b_m - wall.a_m;
    const double part = std::clamp(along.dot(p - wall.a_m) / along.squaredNorm(), 0.0, 1.0);
    return (wall.a_m + part * along - p).norm();
}

const lines_world::Wall& nearest_wall(const lines_world::World& world, const Eigen::Vector2d& p) {
    return *std::min_element(world.walls.begin(), world.walls.end(), [&](const auto& a, const auto& b) {
        return distance_m(a, p) < distance_m(b, p);
    });
}

/// From ends of walls, and from where two walls cross.
double corner_distance_m(const lines_world::World& world, const Eigen::Vector2d& p) {
    double nearest = INFINITY;
    for (const auto& wall : world.walls) {
        nearest = std::min({nearest, (wall.a_m - p).norm(), (wall.b_m - p).norm()});
        const Eigen::Vector2d along = wall.b_m - wall.a_m;
        for (const auto& other : world.walls) {
            const double part = lines_world::range_to(other, wall.a_m, along);
            if (&other != &wall && part < 1)
                nearest = std::min(nearest, (wall.a_m + part * along - p).norm());
        }
    }
    return nearest;
}

TEST(Frame, surfaces_of_exact_walls_are_exact_away_from_corners) {
    std::mt19937_64 random(1);
    int checked = 0, without = 0;
    for (int run = 0; run < 100; ++run) {
        const auto world = lines_world::random_world(random, 4 + run % 4, run % 3);
        const Sensor sensor{1081, 1.5 * M_PI, {0.2, -0.1, 0.4}};
        const Pose2 T = grid_map_world::random_pose(random, 0.5);
        const Eigen::Vector2d sensor_m = T * sensor.T_base_sensor.translation();
        for (const auto& p : grid_map_world::frame_at(world, T, sensor, random).points) {
            const Eigen::Vector2d p_map = T * p.p_base_m.cast<double>();
            // Beyond the window, or the one neighbour that is always taken, no return of another wall has a
            // part.
            const double next_m = 4 * (p_map - sensor_m).norm() * 1.5 * M_PI / 1080;
            if (corner_distance_m(world, p_map) < 0.1 + next_m + 0.01) continue;
            ++checked;
            without += !p.has_normal();
            if (!p.has_normal()) continue;
            const auto& wall = nearest_wall(world, p_map);
            const Eigen::Vector2d normal = normal_towards(wall, sensor_m);
            const Eigen::Vector2d found = Pose2{0, 0, T.phi_rad} * p.normal_base.cast<double>();
            EXPECT_GT(normal.dot(found), 1 - 1e-6) << run;
            EXPECT_LT(distance_m(wall, p_map), 1e-4);
            EXPECT_NEAR(found.norm(), 1, 1e-6);
        }
    }
    EXPECT_GT(checked, 10000);
    EXPECT_LT(without, 0.02 * checked);
}

TEST(Frame, place_and_direction_of_a_surface_err_apart_at_the_ends_of_walls_too) {
    // At the end of a wall the window of a return reaches to one side only. Were the surface put where the
    // return is, a line that is turned would be displaced there as well: by 0.8 of all of it.
    std::mt19937_64 random(12);
    const lines_world::World world{{{{2, -0.5}, {2, 0.5}}}, {}};
    struct Sums {
        double xy = 0, xx = 0, yy = 0;
    } low, high;
    for (int run = 0; run < 2000; ++run) {
        const Sensor sensor{361, M_PI, {0, 0, 0}, 0.01};
        const auto frame = grid_map_world::frame_at(world, {}, sensor, random);
        const auto add = [](const SurfacePoint& p, Sums& sums) {
            if (!p.has_normal()) return;
            const double off_m = p.p_base_m.x() - 2, turned = p.normal_base.y();
            sums.xy += off_m * turned;
            sums.xx += off_m * off_m;
            sums.yy += turned * turned;
        };
        add(frame.points.front(), low);
        add(frame.points.back(), high);
    }
    for (const Sums& sums : {low, high}) EXPECT_LT(std::abs(sums.xy) / std::sqrt(sums.xx * sums.yy), 0.1);
}

TEST(Frame, normals_scatter_as_the_noise_lets_them) {
    // A wall at 2 m, seen by 1081 beams: 18 returns and more within 10 cm to both sides, 5 mm of noise.
    std::mt19937_64 random(2);
    const double sigma_m = 0.005;
    const lines_world::World world{{{{2, -5}, {2, 5}}}, {}};
    double squares = 0, allowed = 0;
    int count = 0;
    for (int run = 0; run < 50; ++run) {
        Sensor sensor{1081, 1.5 * M_PI, {}, sigma_m};
        for (const auto& p : grid_map_world::frame_at(world, {}, sensor, random).points) {
            if (std::abs(p.p_base_m.y()) > 1) continue;
            ASSERT_TRUE(p.has_normal());
            const double off_rad = std::atan2(p.normal_base.y(), -p.normal_base.x());
            // Returns at equal steps d over a length l: var of the slope = 12 sigma^2 d / l^3, of range noise
            // cos(angle) counts.
            const double range_m = std::hypot(2, p.p_base_m.y()), cosine = 2 / range_m,
                         step_m = range_m / cosine * 1.5 * M_PI / 1080;
            squares += off_rad * off_rad;
            allowed += 12 * std::pow(sigma_m * cosine, 2) * step_m / std::pow(0.2, 3);
            ++count;
        }
    }
    ASSERT_GT(count, 1000);
    EXPECT_NEAR(squares / allowed, 1, 0.25);
}

TEST(Frame, a_corner_mixes_its_walls_within_the_window_only) {
    // Two walls that meet at right angles at (2, 0), turned by 45 degrees to the sensor.
    std::mt19937_64 random(3);
    lines_world::World world;
    world.walls = {{{2, 0}, {0, 2}}, {{2, 0}, {0, -2}}};
    int beside = 0;
    const Frame frame = grid_map_world::frame_at(world, {}, {1081, 1.5 * M_PI, {}}, random);
    for (const auto& p : frame.points) {
        if (!p.has_normal()) continue;
        const double away_m = (p.p_base_m - Eigen::Vector2f(2, 0)).norm();
        const double one = std::abs(p.normal_base.dot(Eigen::Vector2f(1, 1).normalized())),
                     other = std::abs(p.normal_base.dot(Eigen::Vector2f(1, -1).normalized()));
        if (away_m > 0.11 + 0.03) {
            EXPECT_GT(std::max(one, other), 1 - 1e-5) << away_m;
            ++beside;
        }
        // Nowhere one that faces along the bisector, as if there were a wall across the corner.
        EXPECT_GT(std::max(one, other), std::cos(30 * M_PI / 180)) << away_m;
    }
    EXPECT_GT(beside, 20);
}

TEST(Frame, surfaces_end_at_corners) {
    // Exact corners of many angles, inner and outer ones, from many distances: no return is drawn off its
    // wall.
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    int beside = 0, off = 0;
    for (int run = 0; run < 200; ++run) {
        const double away_m = 1 + 3 * unit(random), a = M_PI * (0.15 + 0.3 * unit(random)),
                     b = M_PI * (0.15 + 0.3 * unit(random));
        const double outward = run % 2 ? 1 : -1;  // the walls lead away from the sensor, or past it
        const Eigen::Vector2d corner(away_m, 0);
        lines_world::World world;
        world.walls = {{corner, corner + 1.5 * Eigen::Vector2d(outward * std::cos(a), std::sin(a))},
                       {corner, corner + 1.5 * Eigen::Vector2d(outward * std::cos(b), -std::sin(b))}};
        for (const auto& p : grid_map_world::frame_at(world, {}, {1081, 1.5 * M_PI, {}}, random).points) {
            if (!p.has_normal() || (p.p_base_m.cast<double>() - corner).norm() > 0.1) continue;
            ++beside;
            off +=
                distance_m(nearest_wall(world, p.p_base_m.cast<double>()), p.p_base_m.cast<double>()) > 0.003;
        }
    }
    EXPECT_GT(beside, 450);
    EXPECT_LT(off, 0.01 * beside);
}

TEST(Frame, keeps_returns_at_the_spacing) {
    std::mt19937_64 random(4);
    for (const double spacing_m : {0.02, 0.05, 0.1}) {
        FrameSettings settings;
        settings.spacing_m = spacing_m;
        const lines_world::World world{{{{2, -6}, {2, 6}}}, {}};
        Frame frame;
        make_frame(grid_map_world::scan_at(world, {}, {1081, 1.5 * M_PI, {}}, random), {}, settings, frame);
        for (std::size_t i = 1; i < frame.points.size(); ++i) {
            const double apart_m = (frame.points[i].p_base_m - frame.points[i - 1].p_base_m).norm();
            const double range_m = frame.points[i].p_base_m.norm(),
                         step_m = range_m * range_m / 2 * 1.5 * M_PI / 1080;
            // The middles of surfaces, whose windows may reach farther to one side.
            EXPECT_GE(apart_m, spacing_m / 2 - 1e-4);
            EXPECT_LE(apart_m, std::max(spacing_m, step_m) + 1.5 * step_m + 1e-3);
        }
    }
}

TEST(Frame, leaves_out_what_is_too_near_or_too_far) {
    loopline::PlanarScan scan;
    scan.angle_step_rad = 0.01;
    scan.max_range_m = 80;
    scan.ranges_m = {0.05F, 0, 1, 29.9F, 30.1F};
    Frame frame;
    make_frame(scan, {}, {}, frame);
    EXPECT_EQ(frame.points.size(), 2U);
}

/// Where a vehicle is that moves at constant twist, after a part of the motion of a whole sweep.
Pose2 along_the_arc(const SweepMotion& sweep, double part) {
    const double turn = sweep.turn_rad * part;
    const double a = std::abs(turn) < 1e-9 ? 1 : std::sin(turn) / turn,
                 b = std::abs(turn) < 1e-9 ? 0 : (1 - std::cos(turn)) / turn;
    const double x = sweep.forward_m * part, y = sweep.left_m * part;
    return {a * x - b * y, b * x + a * y, turn};
}

TEST(Frame, undoes_the_motion_of_a_sweep) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    double worst_m = 0;
    for (int run = 0; run < 40; ++run) {
        const auto world = lines_world::random_world(random, 5, 0);
        // 25 ms of a sweep at up to 2 m/s and 60 deg/s.
        const SweepMotion sweep{0.05 * unit(random), 0.01 * unit(random), 1.5 * M_PI / 180 * unit(random)};
        const Sensor sensor{541, 1.5 * M_PI, {0.3, 0.1, 0.5}};
        loopline::PlanarScan scan = grid_map_world::scan_at(world, {}, sensor, random);
        for (std::size_t beam = 0; beam < scan.size(); ++beam) {
            const Pose2 T_sensor =
                along_the_arc(sweep, static_cast<double>(beam) / 540) * sensor.T_base_sensor;
            const double bearing = T_sensor.phi_rad + scan.angle_rad(beam);
            double nearest = INFINITY;
            for (const auto& wall : world.walls)
                nearest = std::min(nearest, lines_world::range_to(wall, T_sensor.translation(),
                                                                  {std::cos(bearing), std::sin(bearing)}));
            scan.ranges_m[beam] = static_cast<float>(nearest);
        }
        Frame frame;
        make_frame(scan, sweep, {}, frame);
        ASSERT_GT(frame.points.size(), 100U);
        for (const auto& p : frame.points) {
            // The static scan's walls: what lies at a corner may be drawn to the line of its neighbours.
            const Eigen::Vector2d p_map = p.p_base_m.cast<double>();
            if (corner_distance_m(world, p_map) < 0.4) continue;
            const auto& wall = nearest_wall(world, p_map);
            worst_m = std::max(worst_m, distance_m(wall, p_map));
            if (!p.has_normal()) continue;
            const double cosine = normal_towards(wall, {0, 0}).dot(p.normal_base.cast<double>());
            EXPECT_GT(cosine, std::cos(0.3 * M_PI / 180));
        }
    }
    EXPECT_LT(worst_m, 1e-3);
}

}  // namespace
