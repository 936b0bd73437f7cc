/// Localisation in a finished map, on drives through the buildings of datasets/.
#include <gtest/gtest.h>

#include "support/mapped_building.h"

using namespace loopline;
using namespace loopline::grid_slam;
using namespace loopline::test;

namespace {

TEST(GridLocalisation, follows_a_given_start_and_leaves_the_map_as_it_is) {
    const auto& building = loops_building();
    const auto truth = test::poses_along(*building.scene, 0, 120, 0.25);
    const Pose2 off{0.25, -0.2, 4 * radian_per_degree};
    const auto drive = drive_in(building, starting_at(truth[0] * off), truth, 5);
    EXPECT_LT(drive.rmse_m(), 0.05);
    EXPECT_GT(drive.share_matched, 0.98);
    EXPECT_TRUE(drive.lost.empty());
    EXPECT_EQ(drive.known_from, 0U);
    const FrozenMap fresh(building.picture, 0.05, 0.15);
    EXPECT_TRUE(fresh.grid() == building.map.grid());
    EXPECT_TRUE(fresh.coarse_grid() == building.map.coarse_grid());
}

TEST(GridLocalisation, obeys_a_given_start_that_is_wrong) {
    const auto& building = twin_building();
    // In the second room, 16 m from the first one, which looks the same: what was given counts.
    const auto truth = test::poses_along(*building.scene, 26, 34, 0.2);
    const Pose2 elsewhere{truth[0].x_m - 16, truth[0].y_m, truth[0].phi_rad};
    const auto drive = drive_in(building, starting_at(elsewhere), truth, 1);
    EXPECT_LT((drive.online[0].translation() - elsewhere.translation()).norm(), 0.2);
    EXPECT_LT((drive.online[10].translation() - truth[10].translation() - Eigen::Vector2d(-16, 0)).norm(),
              0.2);
}

TEST(GridLocalisation, takes_maps_that_are_turned_coarse_or_fine) {
    const auto& building = loops_building();
    const auto truth = test::poses_along(*building.scene, 0, 20, 0.2),
               seen = test::poses_along(*building.scene, 0, 24, 0.7);
    struct Case {
        double resolution_m, yaw_rad, rmse_m;
    };
    for (const Case& c : {Case{0.05, 0.7, 0.06}, {0.02, 0, 0.04}, {0.1, -2.1, 0.12}, {0.25, 0, 0.3}}) {
        SCOPED_TRACE(c.resolution_m);
        // The corner of a square picture whose middle is the start.
        const double half_m = 22;
        const Pose2 T_map_picture = Pose2{0, 2, c.yaw_rad} * Pose2{-half_m, -half_m, 0};
        const auto side = static_cast<std::size_t>(2 * half_m / c.resolution_m);
        const FrozenMap map(
            test::map_seen_from(building.world, seen, c.resolution_m, T_map_picture, side, side), 0.05,
            std::max(0.15, 2 * c.resolution_m));
        EXPECT_NEAR(map.cell_m(), std::max(c.resolution_m, c.resolution_m == 0.02 ? 0.04 : 0.05), 1e-12);
        const auto drive =
            test::localise(map, starting_at(truth[0]), truth, 4,
                           [&](std::size_t) -> const lines_world::World& { return building.world; });
        EXPECT_LT(drive.rmse_m(), c.rmse_m);
    }
}

// ---- Surfaces of cells
// -----------------------------------------------------------------------------------------------

MapServerMap drawn(const std::vector<std::string>& rows_from_above) {
    MapServerMap map;
    map.width = rows_from_above[0].size();
    map.height = rows_from_above.size();
    map.resolution_m = 0.05;
    map.cells.resize(map.width * map.height);
    for (std::size_t row = 0; row < map.height; ++row)
        for (std::size_t column = 0; column < map.width; ++column) {
            const char c = rows_from_above[map.height - 1 - row][column];
            map.cells[map.index(column, row)] = c == '#'   ? MapCell::occupied
                                                : c == '.' ? MapCell::free
                                                           : MapCell::unknown;
        }
    return map;
}

/// How many surfaces face along each of +x, -x, +y, -y.
std::array<int, 4> facing(const MapServerMap& map) {
    std::array<int, 4> count{};
    for (const auto& p : grid_map::surfaces_of(grid_map::coarse_occupancy(map, 0.05)).points) {
        count[0] += p.normal_base.x() > 0.9F;
        count[1] += p.normal_base.x() < -0.9F;
        count[2] += p.normal_base.y() > 0.9F;
        count[3] += p.normal_base.y() < -0.9F;
    }
    return count;
}

using Facing = std::array<int, 4>;

TEST(OccupancySurfaces, face_the_free_sides) {
    EXPECT_EQ(facing(drawn({"..........", "##########", "          "})), (Facing{0, 0, 10, 0}));
    EXPECT_EQ(facing(drawn({"..........", "##########", ".........."})), (Facing{0, 0, 10, 10}));
    EXPECT_EQ(facing(drawn({".#.", ".#.", ".#.", ".#.", ".#.", ".#."})), (Facing{6, 6, 0, 0}));
    // What is solid has surfaces only on its outside.
    const auto solid =
        facing(drawn({"................", "................", "..############..", "..############..",
                      "..############..", "..############..", "..############..", "..############..",
                      "................", "................"}));
    EXPECT_GE(solid[2], 8);
    EXPECT_LE(solid[2], 12);
    EXPECT_EQ(solid[2], solid[3]);
    EXPECT_EQ(facing(drawn({"          ", "##########", "          "})), (Facing{0, 0, 0, 0}));
}

TEST(OccupancySurfaces, keep_places_of_fine_cells) {
    MapServerMap fine = drawn(std::vector<std::string>(20, std::string(20, '.')));
    fine.resolution_m = 0.01;
    for (std::size_t column = 0; column < 20; ++column)
        fine.cells[fine.index(column, 12)] = MapCell::occupied;
    const auto coarse = grid_map::coarse_occupancy(fine, 0.05);
    EXPECT_EQ(coarse.width, 4);
    const auto points = grid_map::surfaces_of(coarse).points;
    ASSERT_EQ(points.size(), 8U);
    for (const auto& p : points) EXPECT_NEAR(p.p_base_m.y(), 0.125, 1e-6);
}

}  // namespace
