/// Localisation in a finished map, on drives through the buildings of datasets/.
#include <gtest/gtest.h>

#include "support/localisation_world.h"

using namespace loopline;
using namespace loopline::grid_slam;

namespace {

constexpr double radian_per_degree = M_PI / 180;

/// A building and the map of it by its own drive, made once.
struct MappedBuilding {
    MappedBuilding(const char* dataset, double way_m, const Pose2& T_map_picture, std::size_t width,
                   std::size_t height)
        : scene(test::scene_of(test::dataset(dataset))),
          world(test::walls_of(*scene)),
          picture(test::map_seen_from(world, test::poses_along(*scene, 0, way_m, 1), 0.05, T_map_picture,
                                      width, height)),
          map(picture, 0.05, 0.15) {}
    std::unique_ptr<simulation::Scene> scene;
    lines_world::World world;
    MapServerMap picture;
    FrozenMap map;
};

const MappedBuilding& loops_building() {
    static const MappedBuilding building("cart_loops.ini", 260, {-19.6, -4.9, 0}, 784, 630);
    return building;
}

const MappedBuilding& twin_building() {
    static const MappedBuilding building("cart_twin_rooms.ini", 185, {-28.4, -17.4, 0}, 700, 560);
    return building;
}

LocalisationSettings starting_at(const Pose2& T_map_start) {
    LocalisationSettings settings;
    settings.T_map_start = T_map_start;
    return settings;
}

LocalisationSettings starting_anywhere() {
    LocalisationSettings settings;
    settings.start_given = false;
    return settings;
}

test::LocalisedDrive drive_in(const MappedBuilding& building, const LocalisationSettings& settings,
                              const std::vector<Pose2>& truth, std::uint64_t seed) {
    return test::localise(building.map, settings, truth, seed,
                          [&](std::size_t) -> const lines_world::World& { return building.world; });
}

/// Whether a place that was told at its time was ever a wrong one.
void expect_never_wrong(const test::LocalisedDrive& drive) {
    for (std::size_t k = 0; k < drive.truth.size(); ++k) {
        if (!drive.known[k]) continue;
        ASSERT_LT((drive.online[k].translation() - drive.truth[k].translation()).norm(), 0.3) << k;
    }
}

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

TEST(GridLocalisation, finds_its_start_from_anywhere) {
    const auto& building = loops_building();
    for (const double from_m : {35.0, 90.0, 215.0}) {
        SCOPED_TRACE(from_m);
        const auto truth = test::poses_along(*building.scene, from_m, from_m + 9, 0.2);
        const auto drive = drive_in(building, starting_anywhere(), truth, static_cast<std::uint64_t>(from_m));
        ASSERT_TRUE(drive.ever_known) << drive.why_not;
        expect_never_wrong(drive);
        EXPECT_GT(drive.known_from, 5U) << "one look is not enough";
        EXPECT_LT(drive.known_after_m, 8);
        // Those before it are laid out backwards.
        EXPECT_LT(drive.rmse_m(), 0.06);
        for (std::size_t k = 0; k < drive.truth.size(); ++k) EXPECT_LT(drive.error_m(k), 0.2) << k;
    }
}

TEST(GridLocalisation, waits_in_one_of_two_rooms_that_are_alike) {
    const auto& building = twin_building();
    for (const double from_m : {22.0, 130.0}) {
        SCOPED_TRACE(from_m);
        const auto truth = test::poses_along(*building.scene, from_m, from_m + 35, 0.25);
        const Eigen::Vector2d middle_m(from_m < 100 ? -1 : -17, -14);
        ASSERT_LT((truth[0].translation() - middle_m).cwiseAbs().maxCoeff(), 3) << "it starts in the room";
        const auto drive = drive_in(building, starting_anywhere(), truth, 3);
        expect_never_wrong(drive);
        ASSERT_TRUE(drive.ever_known) << drive.why_not;
        EXPECT_GT(drive.known_after_m, 6);
        EXPECT_LT(drive.error_m(0), 0.3) << "the first pose, by the motion back from where it became certain";
    }
}

TEST(GridLocalisation, says_that_it_is_lost_and_finds_itself_again) {
    const auto& building = loops_building();
    const auto truth = test::poses_along(*building.scene, 30, 75, 0.2);
    const auto elsewhere = grid_map_world::corridor(3, 0.3);
    const auto drive = test::localise(building.map, starting_at(truth[0]), truth, 2,
                                      [&](std::size_t k) -> const lines_world::World& {
                                          return k > 40 && k < 90 ? elsewhere : building.world;
                                      });
    ASSERT_EQ(drive.lost.size(), 1U);
    EXPECT_TRUE(drive.lost[0].found);
    EXPECT_GT(drive.lost[0].first_scan, 41U);
    EXPECT_LT(drive.error_m(truth.size() - 1), 0.1);
    EXPECT_LT(drive.error_m(40), 0.1);
    for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_LT(drive.error_m(k), 1) << k;
}

TEST(GridLocalisation, is_never_certain_in_a_map_of_another_building) {
    const auto& building = twin_building();
    const auto truth = test::poses_along(*loops_building().scene, 0, 12, 0.25);
    const auto drive =
        test::localise(building.map, starting_anywhere(), truth, 1,
                       [&](std::size_t) -> const lines_world::World& { return loops_building().world; });
    EXPECT_FALSE(drive.ever_known);
    EXPECT_FALSE(drive.why_not.empty());
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
