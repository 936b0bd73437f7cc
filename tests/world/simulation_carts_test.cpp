/// The worlds of carts over many seeds: clear of everything, and back at the start.
#include <gtest/gtest.h>

#include "support/simulated_scene.h"

using namespace loopline;
using namespace loopline::test;

TEST(SimulatedCarts, keep_clear_of_everything_and_come_back) {
    for (const char* name : {"cart_loops.ini", "cart_corridor.ini", "cart_twin_rooms.ini"})
        for (int seed = 1; seed <= 20; ++seed) {
            const auto scene = scene_of(dataset(name), {"simulation.seed=" + std::to_string(seed)});
            EXPECT_GT(clearance_m(*scene), 0.3) << name << ", seed " << seed;
            EXPECT_LT(scene->drive.motion.last().translation().norm(), 0.2) << name << ", seed " << seed;
        }
}

TEST(SimulatedCarts, can_be_driven_lap_after_lap) {
    for (const char* name : {"cart_loops.ini", "cart_corridor.ini", "cart_twin_rooms.ini"}) {
        SCOPED_TRACE(name);
        const auto once = scene_of(dataset(name));
        const auto ten = scene_of(dataset(name), {"route.laps=10"});
        const double standing_s = 13;
        EXPECT_NEAR((seconds_between(0, ten->duration_ns()) - standing_s) /
                        (seconds_between(0, once->duration_ns()) - standing_s),
                    10, 0.3);
        EXPECT_EQ(once->world.walls.size(), ten->world.walls.size()) << "furniture is that of the route";
        EXPECT_LT(ten->drive.motion.last().translation().norm(), 0.2);
    }
}
