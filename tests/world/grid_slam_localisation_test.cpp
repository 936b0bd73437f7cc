/// Starts that are not given, and drives that get lost, in buildings of scenarios.
#include <gtest/gtest.h>

#include "support/mapped_building.h"

using namespace loopline;
using namespace loopline::grid_slam;
using namespace loopline::test;

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
