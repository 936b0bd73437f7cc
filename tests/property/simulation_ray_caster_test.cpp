/// The grid of the ray caster changes nothing: the same hit as when every wall is tried.
#include <gtest/gtest.h>

#include <cmath>

#include "simulation/floor_plan.h"
#include "simulation/random_stream.h"
#include "simulation/ray_caster.h"

using namespace loopline;
using namespace loopline::simulation;

namespace {

World random_world(RandomStream& random, int walls, double size_m) {
    World world;
    world.ceiling_m = random.chance(0.5) ? 3 : std::numeric_limits<double>::infinity();
    for (int i = 0; i < walls; ++i) {
        const Eigen::Vector2d from_m(random.uniform(0, size_m), random.uniform(0, size_m));
        const double length_m = random.chance(0.2) ? random.uniform(0, size_m) : random.uniform(0, 3);
        double angle_rad = random.uniform(-M_PI, M_PI);
        if (random.chance(0.5)) angle_rad = random.index(4) * M_PI / 2;  // along the grid too
        const double bottom_m = random.chance(0.3) ? random.uniform(0, 2) : 0;
        world.walls.push_back({from_m,
                               from_m + length_m * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad)),
                               bottom_m, bottom_m + random.uniform(0.1, 3)});
    }
    return world;
}

Eigen::Vector3d random_direction(RandomStream& random) {
    switch (random.index(4)) {
        case 0: {  // along an axis
            Eigen::Vector3d axis = Eigen::Vector3d::Zero();
            axis[random.index(3)] = random.chance(0.5) ? 1 : -1;
            return axis;
        }
        case 1: {  // level
            const double a = random.uniform(-M_PI, M_PI);
            return {std::cos(a), std::sin(a), 0};
        }
        default: {
            Eigen::Vector3d v(random.normal(1), random.normal(1), random.normal(0.5));
            return v.normalized();
        }
    }
}

}  // namespace

TEST(RayCaster, meets_what_brute_force_meets) {
    RandomStream random(1, "test");
    int hits = 0;
    for (int trial = 0; trial < 60; ++trial) {
        const double size_m = random.uniform(1, 200);
        const World world = random_world(random, 1 + random.index(200), size_m);
        const RayCaster caster(world);
        for (int ray = 0; ray < 500; ++ray) {
            // From inside and from outside of the grid, and from the end of a wall.
            Eigen::Vector3d origin_m(random.uniform(-0.3, 1.3) * size_m, random.uniform(-0.3, 1.3) * size_m,
                                     random.uniform(0.01, 2.9));
            if (random.chance(0.1)) origin_m.head<2>() = world.walls[0].from_m;
            const Eigen::Vector3d direction = random_direction(random);
            const double reach_m = random.chance(0.3) ? random.uniform(0.1, 20) : 1000;
            const Hit fast = caster.cast(origin_m, direction, reach_m);
            const Hit slow = caster.cast_at_all_walls(origin_m, direction, reach_m);
            ASSERT_EQ(fast.range_m, slow.range_m) << "trial " << trial << ", ray " << ray;
            hits += fast.surface >= 0;
        }
    }
    EXPECT_GT(hits, 5000) << "the test would be empty";
}

TEST(RayCaster, no_ray_slips_through_a_corner) {
    World world;
    add_box(world, {0, 0}, 4, 4, 0.3, 5);
    const RayCaster caster(world);
    RandomStream random(2, "test");
    for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3d inside(random.uniform(-1, 1), random.uniform(-1, 1), 1);
        // Straight at a corner, as exactly as doubles can.
        const Eigen::Vector2d corner = world.walls[static_cast<std::size_t>(random.index(4))].from_m;
        const Eigen::Vector2d level = (corner - inside.head<2>()).normalized();
        const Hit hit = caster.cast(inside, {level.x(), level.y(), 0}, 100);
        ASSERT_NEAR(hit.range_m, (corner - inside.head<2>()).norm(), 1e-6);
    }
}

TEST(RayCaster, ground_ceiling_lintels_and_people) {
    World world;
    world.ceiling_m = 3;
    world.walls.push_back({{5, -5}, {5, 5}, 2, 3});  // a lintel
    world.walls.push_back({{8, -5}, {8, 5}, 0, 1});  // a parapet
    const RayCaster caster(world);
    const Eigen::Vector3d eye(0, 0, 1.5);
    const auto at_slope = [&](double slope) {
        return caster.cast(eye, Eigen::Vector3d(1, 0, slope).normalized(), 100);
    };
    EXPECT_EQ(at_slope(0).surface, Hit::nothing) << "between lintel and parapet";
    EXPECT_EQ(at_slope(0.2).surface, 0);
    EXPECT_NEAR(at_slope(0.2).range_m, 5 * std::hypot(1, 0.2), 1e-12);
    EXPECT_EQ(at_slope(-0.1).surface, 1);
    EXPECT_EQ(at_slope(-0.5).surface, Hit::ground);
    EXPECT_NEAR(at_slope(-0.5).range_m, 3 * std::hypot(1, 0.5), 1e-12);
    EXPECT_EQ(at_slope(1).surface, Hit::ceiling);
    const std::vector<Cylinder> people{{{3, 0.1}, 0.2, 1.7}};
    const Hit person = caster.cast(eye, {1, 0, 0}, 100, people);
    EXPECT_EQ(person.surface, Hit::cylinder);
    EXPECT_NEAR(person.range_m, 3 - std::sqrt(0.2 * 0.2 - 0.1 * 0.1), 1e-12);
    EXPECT_EQ(caster.cast(eye, Eigen::Vector3d(1, 0, 0.2).normalized(), 100, people).surface, 0)
        << "over the person's head";
}
