/// Buildings of scenarios with a map of them, each made once.
#pragma once

#include <gtest/gtest.h>

#include "support/localisation_world.h"

namespace loopline::test {

using grid_slam::FrozenMap;
using grid_slam::LocalisationSettings;

constexpr double radian_per_degree = M_PI / 180;

/// A building and the map of it by its own drive, made once.
struct MappedBuilding {
    MappedBuilding(const std::string& scenario_file, double way_m, const Pose2& T_map_picture,
                   std::size_t width, std::size_t height)
        : scene(scene_of(scenario_file)),
          world(walls_of(*scene)),
          picture(map_seen_from(world, poses_along(*scene, 0, way_m, 1), 0.05, T_map_picture, width, height)),
          map(picture, 0.05, 0.15) {}
    std::unique_ptr<simulation::Scene> scene;
    lines_world::World world;
    MapServerMap picture;
    FrozenMap map;
};

inline const MappedBuilding& loops_building() {
    static const MappedBuilding building(test_scenario("cart_floor.ini"), 260, {-19.6, -4.9, 0}, 784, 630);
    return building;
}

inline const MappedBuilding& twin_building() {
    static const MappedBuilding building(dataset("cart_twin_rooms.ini"), 185, {-28.4, -17.4, 0}, 700, 560);
    return building;
}

inline LocalisationSettings starting_at(const Pose2& T_map_start) {
    LocalisationSettings settings;
    settings.T_map_start = T_map_start;
    return settings;
}

inline LocalisationSettings starting_anywhere() {
    LocalisationSettings settings;
    settings.start_given = false;
    return settings;
}

inline LocalisedDrive drive_in(const MappedBuilding& building, const LocalisationSettings& settings,
                               const std::vector<Pose2>& truth, std::uint64_t seed) {
    return localise(building.map, settings, truth, seed,
                    [&](std::size_t) -> const lines_world::World& { return building.world; });
}

/// Whether a place that was told at its time was ever a wrong one.
inline void expect_never_wrong(const LocalisedDrive& drive) {
    for (std::size_t k = 0; k < drive.truth.size(); ++k) {
        if (!drive.known[k]) continue;
        ASSERT_LT((drive.online[k].translation() - drive.truth[k].translation()).norm(), 0.3) << k;
    }
}

}  // namespace loopline::test
