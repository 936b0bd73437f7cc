/// Worlds: drawn by rows, and by the generators.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulation/campus_plan.h"
#include "simulation/floor_plan.h"
#include "simulation/office_plan.h"

using namespace loopline;
using namespace loopline::simulation;

namespace {

bool has_wall(const World& world, Eigen::Vector2d a, Eigen::Vector2d b, double bottom_m = 0) {
    return std::any_of(world.walls.begin(), world.walls.end(), [&](const Wall& w) {
        return w.bottom_m == bottom_m && (((w.from_m - a).norm() < 1e-9 && (w.to_m - b).norm() < 1e-9) ||
                                          ((w.from_m - b).norm() < 1e-9 && (w.to_m - a).norm() < 1e-9));
    });
}

double distance_m(const Wall& wall, const Eigen::Vector2d& p) {
    const Eigen::Vector2d way_m = wall.to_m - wall.from_m;
    const double part = std::clamp((p - wall.from_m).dot(way_m) / way_m.squaredNorm(), 0.0, 1.0);
    return (wall.from_m + part * way_m - p).norm();
}

/// The nearest that the route comes to any wall that reaches down to the vehicle.
double clearance_m(const GeneratedPlan& plan) {
    double least_m = 1e9;
    for (std::size_t leg = 0; leg + 1 < plan.route.size(); ++leg)
        for (int i = 0; i <= 100; ++i) {
            const Eigen::Vector2d p = plan.route[leg] + i * 0.01 * (plan.route[leg + 1] - plan.route[leg]);
            for (const Wall& wall : plan.world.walls)
                if (wall.bottom_m < 1) least_m = std::min(least_m, distance_m(wall, p));
        }
    return least_m;
}

}  // namespace

TEST(FloorPlan, a_door_is_set_back_to_the_left_under_a_lintel) {
    FloorPlan plan;
    plan.walls = {{0, 0, 10, 0}};
    plan.doors = {{2, 0, 3, 0, 0.2}};
    plan.pilasters = {{6, 0, 5, 0, 0.1}};  // drawn the other way round: to the other side
    plan.points = {{1, 2, 0.2}, {2, 5, -0.1}, {3, 10, 0}};
    std::vector<PlanProblem> problems;
    const World world = build_world(plan, problems);
    EXPECT_TRUE(problems.empty());
    EXPECT_EQ(world.walls.size(), 3u + 4 + 3) << "three pieces of wall, door with lintel, pilaster";
    EXPECT_TRUE(has_wall(world, {0, 0}, {2, 0}));
    EXPECT_TRUE(has_wall(world, {2, 0}, {2, 0.2}));
    EXPECT_TRUE(has_wall(world, {2, 0.2}, {3, 0.2}));
    EXPECT_TRUE(has_wall(world, {2, 0}, {3, 0}, 2.1));
    EXPECT_TRUE(has_wall(world, {3, 0}, {5, 0}));
    EXPECT_TRUE(has_wall(world, {5, -0.1}, {6, -0.1}));
    EXPECT_TRUE(has_wall(world, {6, 0}, {10, 0}));
    EXPECT_EQ(world.points.size(), 3u);
    EXPECT_EQ(world.ceiling_m, 2.8);
}

TEST(FloorPlan, says_which_row_is_wrong) {
    FloorPlan plan;
    plan.walls = {{0, 0, 10, 0}, {5, 5, 5, 5}};
    plan.doors = {{2, 0, 3, 0, 0.2}, {2.5, 0, 4, 0, 0.2}, {7, 0, 7, 0, 1}};
    plan.points = {{1, 2, 0}, {1, 3, 0}, {2, 2.5, 1}, {2.5, 0, 0}};
    plan.boxes = {{0, 0, 0, 1, 0, 1}};
    std::vector<PlanProblem> problems;
    build_world(plan, problems);
    std::vector<std::pair<std::string, std::size_t>> where;
    for (const auto& problem : problems) where.emplace_back(problem.key, problem.row);
    const std::vector<std::pair<std::string, std::size_t>> expected{
        {"wall_m", 1},  {"door_m", 1},  {"door_m", 2}, {"box_m", 0},
        {"point_m", 1}, {"point_m", 2}, {"point_m", 3}};
    EXPECT_EQ(where, expected);
}

TEST(Campus, has_its_walls_and_no_two_on_one_line) {
    const GeneratedPlan plan = make_campus({}, 1);
    ASSERT_GE(plan.world.walls.size(), 3000u);
    ASSERT_LT(plan.world.walls.size(), 3400u);
    struct Line {
        double alpha, rho;
    };
    std::vector<Line> lines;
    for (const Wall& wall : plan.world.walls) {
        const Eigen::Vector2d way = (wall.to_m - wall.from_m).normalized();
        lines.push_back({std::atan2(way.x(), -way.y()), Eigen::Vector2d(-way.y(), way.x()).dot(wall.from_m)});
    }
    std::sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.alpha < b.alpha; });
    int same = 0;
    for (std::size_t i = 0; i < lines.size(); ++i)
        for (std::size_t k = i + 1; k < lines.size() && lines[k].alpha - lines[i].alpha < 1e-4; ++k)
            same += std::abs(lines[i].rho - lines[k].rho) < 0.01;
    EXPECT_LE(same, 3);
    EXPECT_GT(clearance_m(plan), 1.5);
    for (const Wall& wall : plan.world.walls) EXPECT_GT((wall.to_m - wall.from_m).norm(), 0.75);
}

TEST(Office, leads_through_open_doors_past_the_furniture) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const OfficeSettings settings;
        const GeneratedPlan plan = make_office(settings, 2.7, seed);
        EXPECT_GT(clearance_m(plan), 0.35) << "seed " << seed;
        EXPECT_EQ(plan.walkers.size(), static_cast<std::size_t>(settings.people));
        EXPECT_EQ(plan.route.front(), Eigen::Vector2d(0, 0));
        EXPECT_NE(plan.world.walls[0].to_m, make_office(settings, 2.7, seed + 1).world.walls[0].to_m);
    }
}

TEST(Walkers, walk_to_and_fro_and_step_aside) {
    const Walker walker{{0, 0}, {4, 0}, 1, 0, 0.2, 1.7};
    const Eigen::Vector2d far_away(100, 0);
    EXPECT_NEAR(walkers_at({walker}, 0, far_away)[0].centre_m.x(), 0, 1e-12);
    EXPECT_NEAR(walkers_at({walker}, 3'000'000'000, far_away)[0].centre_m.x(), 3, 1e-9);
    EXPECT_NEAR(walkers_at({walker}, 5'000'000'000, far_away)[0].centre_m.x(), 3, 1e-9);
    for (int i = 0; i < 100; ++i) {
        const Eigen::Vector2d vehicle_m(2, 0.05);
        const auto at = walkers_at({walker}, i * 80'000'000LL, vehicle_m, 0.7);
        EXPECT_GE((at[0].centre_m - vehicle_m).norm(), 0.7 - 1e-12);
    }
}
