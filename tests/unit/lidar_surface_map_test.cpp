/// The map of a spinning lidar: surfaces of cubes, and which way is up by the walls among them.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "lidar_mapping/upright_walls.h"
#include "support/lidar_yard.h"

using namespace loopline;
using namespace loopline::lidar_mapping;
using namespace loopline::lidar_yard;

namespace {

TEST(SurfaceMap, plane_of_a_cube_is_that_of_least_squares) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    int planes = 0;
    for (int run = 0; run < 200; ++run) {
        // In the cube 0 .. 0.5 m, one return for each of its parts.
        SurfaceMapSettings settings;
        settings.sizes = 1;
        SurfaceMap map(settings);
        const Eigen::Vector3d n = Eigen::Vector3d(normal(random), normal(random), normal(random))
                                      .normalized(),
                              a = n.unitOrthogonal(), b = n.cross(a), middle(0.25, 0.25, 0.25);
        std::vector<Eigen::Vector3d> counted;
        std::set<std::array<int, 3>> seen;
        std::uniform_real_distribution<double> across(-0.2, 0.2);
        for (int k = 0; k < 40; ++k) {
            const Eigen::Vector3d p =
                middle + across(random) * a + across(random) * b + 0.01 * normal(random) * n;
            if (p.minCoeff() < 0 || p.maxCoeff() >= 0.5) continue;
            map.add(0, {p, no_noise});
            const std::array<int, 3> part = {static_cast<int>(p.x() * 8), static_cast<int>(p.y() * 8),
                                             static_cast<int>(p.z() * 8)};
            if (seen.insert(part).second) counted.push_back(p);
        }
        const SurfaceMatch match = map.find(from_above(middle));
        if (match.kind != SurfaceKind::plane) continue;
        ++planes;
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (const auto& p : counted) mean += p / static_cast<double>(counted.size());
        for (const auto& p : counted) covariance += (p - mean) * (p - mean).transpose();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
        const Eigen::Vector3d direction = match.direction_map.cast<double>();
        // A surface is fitted anew when it has an eighth more returns, so the last few may have no part.
        EXPECT_GT(std::abs(direction.dot(eigen.eigenvectors().col(0))), std::cos(4 * deg)) << run;
        EXPECT_LT(std::abs(direction.dot(match.offset_m.cast<double>() - (middle - mean))), 0.01);
    }
    EXPECT_GT(planes, 100);
}

TEST(SurfaceMap, what_is_seen_again_at_the_same_place_counts_once) {
    SurfaceMapSettings settings;
    settings.sizes = 1;
    settings.sigma_range_m = 0.01;
    SurfaceMap map(settings);
    // One ring across a cube, a hundred times: a line, which is no plane.
    for (int round = 0; round < 100; ++round)
        for (double y = 0.02; y < 0.5; y += 0.04) map.add(0, {{0.1 + 0.001 * (round % 7), y, 0.2}, no_noise});
    EXPECT_EQ(map.find(from_above({0.1, 0.2, 0.2})).kind, SurfaceKind::none);
    // And what lies between the rings has its part still, when the lidar has moved on.
    for (double x = 0.02; x < 0.5; x += 0.06)
        for (double y = 0.02; y < 0.5; y += 0.06) map.add(0, {{x, y, 0.2}, no_noise});
    const SurfaceMatch match = map.find(from_above({0.4, 0.4, 0.21}));
    ASSERT_EQ(match.kind, SurfaceKind::plane);
    EXPECT_GT(std::abs(match.direction_map.z()), 0.9999F);
    EXPECT_NEAR(std::abs(match.direction_map.dot(match.offset_m)), 0.01, 1e-3);
}

TEST(SurfaceMap, places_at_once_find_what_each_finds_alone) {
    std::mt19937_64 random(8);
    std::uniform_real_distribution<double> anywhere(-6, 6);
    const SurfaceMapSettings settings;
    SurfaceMap together(settings), one_by_one(settings);
    std::vector<PlacedReturn> returns;
    for (int k = 0; k < 30000; ++k)
        returns.push_back({{anywhere(random), anywhere(random), k % 3 == 0 ? 0.3 : 2.4}, no_noise});
    for (std::size_t size = 0; size < together.sizes(); ++size) {
        together.add(size, returns);
        for (const PlacedReturn& seen : returns) one_by_one.add(size, seen);
    }
    EXPECT_EQ(together.cells(), one_by_one.cells());
    int found = 0, none = 0;
    for (int run = 0; run < 200; ++run) {
        std::array<MapReturn, SurfaceMap::at_once> seen;
        std::array<SurfaceMatch, SurfaceMap::at_once> matches;
        for (MapReturn& s : seen) s = from_above({anywhere(random), anywhere(random), anywhere(random)});
        const std::size_t count = 1 + static_cast<std::size_t>(run) % SurfaceMap::at_once, smallest = run % 2;
        together.find(seen.data(), count, smallest, matches.data());
        for (std::size_t k = 0; k < count; ++k) {
            const SurfaceMatch alone = one_by_one.find(seen[k], smallest);
            ASSERT_EQ(matches[k].kind, alone.kind);
            ++(alone.kind == SurfaceKind::none ? none : found);
            if (alone.kind == SurfaceKind::none) continue;
            EXPECT_EQ(matches[k].offset_m, alone.offset_m);
            EXPECT_EQ(matches[k].direction_map, alone.direction_map);
            EXPECT_EQ(matches[k].variance_m2, alone.variance_m2);
        }
    }
    EXPECT_GT(found, 100);
    EXPECT_GT(none, 100);
}

/// One ring of a lidar 1.8 m above the ground, 15 m away, seen again and again with noise of its ranges: the
/// noise spreads it along the beams, into a plane that contains them.
TEST(SurfaceMap, noise_of_ranges_makes_no_plane_of_a_ring) {
    std::mt19937_64 random(8);
    std::normal_distribution<double> normal;
    const double sigma_m = 0.05;
    int with = 0, without = 0;
    for (int run = 0; run < 50; ++run) {
        SurfaceMapSettings settings;
        settings.sigma_range_m = 0.01;
        SurfaceMap told(settings), untold(settings);
        const Eigen::Vector3d lidar(-15 + 0.01 * run, 0.25, 1.9);
        for (int k = 0; k < 400; ++k) {
            const double azimuth = 0.016 * (k % 20 - 9.5) / 10;
            Eigen::Vector3d beam(std::cos(azimuth), std::sin(azimuth), -1.8 / 15.25);
            beam.normalize();
            const double range_m = -1.8 / beam.z() + sigma_m * normal(random);
            const Eigen::Vector3d p = lidar + range_m * beam;
            const Eigen::Vector3f b = beam.cast<float>();
            const Eigen::Matrix3f noise = static_cast<float>(sigma_m * sigma_m) * b * b.transpose();
            for (std::size_t size = 0; size < told.sizes(); ++size) {
                told.add(size, {p, noise});
                untold.add(size, {p, no_noise});
            }
        }
        const Eigen::Vector3d place(0.25 + 0.01 * run, 0.25, 0.1);
        const MapReturn seen{place, (place - lidar).normalized().cast<float>()};
        with += told.find(seen).kind == SurfaceKind::plane ? 1 : 0;
        without += untold.find(seen).kind == SurfaceKind::plane ? 1 : 0;
    }
    EXPECT_LE(with, 2);
    EXPECT_GT(without, 20);
}

/// A floor that lies 2.5 cm below a face of the cube's parts: noise puts one return in ten across it, and the
/// parts there must not count as much as those that hold the floor.
TEST(SurfaceMap, noise_across_a_face_of_parts_does_not_draw_a_surface_to_it) {
    std::mt19937_64 random(14);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> across(0, 0.5);
    constexpr double sigma_m = 0.02, floor_m = 0.1;
    const Eigen::Matrix3f told =
        Eigen::Vector3f(0, 0, static_cast<float>(sigma_m * sigma_m)).asDiagonal().toDenseMatrix();
    SurfaceMapSettings settings;
    settings.sizes = 1;
    double off_m = 0, off_if_untold_m = 0;
    int planes = 0, planes_if_untold = 0;
    for (int run = 0; run < 100; ++run) {
        SurfaceMap map(settings), untold(settings);
        for (int k = 0; k < 1000; ++k) {
            const Eigen::Vector3d p(across(random), across(random), floor_m + sigma_m * normal(random));
            map.add(0, {p, told});
            untold.add(0, {p, no_noise});
        }
        const auto measure = [&](const SurfaceMap& of, double& sum_m, int& count) {
            const SurfaceMatch match = of.find(from_above({0.25, 0.25, floor_m}));
            if (match.kind != SurfaceKind::plane) return;
            EXPECT_GT(std::abs(match.direction_map.z()), 0.98F);
            sum_m -= static_cast<double>(match.offset_m.z());
            ++count;
        };
        measure(map, off_m, planes);
        measure(untold, off_if_untold_m, planes_if_untold);
    }
    EXPECT_GT(planes, 50);
    EXPECT_GT(planes_if_untold, 50);
    EXPECT_LT(std::abs(off_m / planes), 0.004);
    EXPECT_GT(std::abs(off_if_untold_m / planes_if_untold), 0.01);
}

/// A map that leans, of walls, a floor and a roof; a car beside it leans otherwise.
TEST(UprightWalls, tell_which_way_is_up) {
    std::mt19937_64 random(21);
    std::normal_distribution<double> normal;
    auto panels = yard();
    panels.push_back({{-5, -4, 0}, {8, 0, 0}, {0, 0.35, 1.5}});  // its side, 13 degrees off
    const Eigen::Vector3d lean_rad(2 * deg, -1.2 * deg, 0);
    const Eigen::Quaterniond R_map_level = inertial::exp_so3(lean_rad);
    const auto map_of_part = [&](const std::vector<Panel>& seen, int points) {
        SurfaceMap map{SurfaceMapSettings{}};
        for (int k = 0; k < points; ++k) {
            const Panel& panel = any_of(seen, random);
            const Eigen::Vector3d n = panel.edge_a_m.cross(panel.edge_b_m).normalized();
            for (std::size_t size = 0; size < 2; ++size)
                map.add(size,
                        {R_map_level * (place_on(panel, random) + 0.02 * normal(random) * n), no_noise});
        }
        return map;
    };
    const auto off_rad = [&](const Upright& upright) -> Eigen::Vector2d {
        return (R_map_level.conjugate() * upright.up_map).head<2>();
    };
    const auto upright = upright_by_walls(map_of_part(panels, 300000));
    ASSERT_TRUE(upright.has_value());
    EXPECT_LT(off_rad(*upright).norm(), 0.3 * deg);
    EXPECT_LT(std::sqrt(upright->covariance_rad2.trace()), 0.4 * deg);

    // Walls along x alone: of the turn about y they tell nothing.
    const auto along_x = upright_by_walls(map_of_part({panels[0], panels[1], panels[2]}, 250000));
    ASSERT_TRUE(along_x.has_value());
    EXPECT_LT(std::abs(off_rad(*along_x).y()), 3 * std::sqrt(along_x->covariance_rad2(0, 0)));
    EXPECT_LT(std::sqrt(along_x->covariance_rad2(0, 0)), 0.4 * deg);
    EXPECT_GT(std::sqrt(along_x->covariance_rad2(1, 1)), 1.2 * deg);
    EXPECT_FALSE(upright_by_walls(map_of_part({panels[0]}, 20000)).has_value());
}

TEST(SurfaceMap, knows_where_returns_were_as_brute_force_does) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> place(-3, 3);
    const auto drawn = [&] { return Eigen::Vector3d(place(random), place(random), place(random)); };
    SurfaceMap map(SurfaceMapSettings{});
    // Which eighth of a metre, from the middle of nowhere.
    const auto part_of = [](const Eigen::Vector3d& p_m) {
        return Eigen::Array3i((8 * p_m.array()).floor().cast<int>());
    };
    std::vector<Eigen::Array3i> seen;
    for (int k = 0; k < 3000; ++k) {
        const Eigen::Vector3d p_m = drawn();
        map.add(0, {p_m, no_noise});
        seen.push_back(part_of(p_m));
    }
    int near = 0;
    constexpr int asked = 3000;
    for (int k = 0; k < asked; ++k) {
        const Eigen::Vector3d p_m = drawn();
        const Eigen::Array3i part = part_of(p_m);
        const bool expected = std::any_of(seen.begin(), seen.end(), [&](const Eigen::Array3i& other) {
            return (other - part).abs().maxCoeff() <= 1;
        });
        EXPECT_EQ(map.has_return_near(p_m), expected) << p_m.transpose();
        near += expected ? 1 : 0;
    }
    EXPECT_GT(near, asked / 4);
    EXPECT_LT(near, 3 * asked / 4);
}

TEST(SurfaceMap, forgets_what_is_far_and_keeps_the_rest) {
    std::mt19937_64 random(4);
    SurfaceMapSettings settings;
    settings.keep_radius_m = 20;
    SurfaceMap map(settings);
    for (int k = 0; k < 200000; ++k) {
        std::uniform_real_distribution<double> x(-100, 100), y(-3, 3);
        const Eigen::Vector3d p(x(random), y(random), 0.1);
        for (std::size_t size = 0; size < map.sizes(); ++size) map.add(size, {p, no_noise});
    }
    const std::size_t before = map.cells();
    ASSERT_EQ(map.find(from_above({50, 1, 0.1})).kind, SurfaceKind::plane);
    map.keep_around({-10, 0, 0});
    EXPECT_LT(map.cells(), before / 3);
    EXPECT_EQ(map.find(from_above({50, 1, 0.1})).kind, SurfaceKind::none);
    EXPECT_EQ(map.find(from_above({-25, 1, 0.1})).kind, SurfaceKind::plane);
}

}  // namespace
