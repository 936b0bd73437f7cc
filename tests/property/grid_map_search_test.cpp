/// Branch and bound against trying all places: the same place and the same score, whatever the map and the
/// window.
#include <gtest/gtest.h>

#include "grid_map/search.h"
#include "property/grid_map_world.h"

using namespace loopline::grid_map;
using loopline::Pose2;

namespace {

struct SearchCase {
    ScanGrid grid{{}};
    std::vector<Eigen::Vector2f> points;
    SearchWindow window;
};

enum class Kind { room, corridor, clutter, empty };

std::vector<Eigen::Vector2f> random_points(std::mt19937_64& random, int count, double reach_m) {
    std::vector<Eigen::Vector2f> points;
    for (const auto& p : grid_map_world::random_frame(random, count, reach_m).points)
        points.push_back(p.p_base_m);
    return points;
}

void fill_map(std::mt19937_64& random, Kind kind, const Pose2& around, SearchCase& c) {
    const grid_map_world::Sensor sensor{61, M_PI, {0.1, 0.05, 0.1}, 0.02};
    const auto count = random() % 40;
    if (kind == Kind::room || kind == Kind::corridor) {
        const auto world = kind == Kind::room ? lines_world::random_world(random, 4, 2)
                                              : grid_map_world::corridor(2, random() % 2 ? 0 : M_PI / 2);
        const Pose2 T = grid_map_world::random_pose(random, 0.4, 0.3);
        c.grid.insert(grid_map_world::frame_at(world, {}, sensor, random), around);
        c.points = search_points(grid_map_world::frame_at(world, T, sensor, random), count);
        return;
    }
    if (kind == Kind::clutter) c.grid.insert(grid_map_world::random_frame(random, 30, 2), around);
    c.points = random_points(random, static_cast<int>(count), 2);
}

void choose_window(std::mt19937_64& random, const Pose2& around, SearchWindow& window) {
    std::uniform_real_distribution<double> unit(0, 1);
    window.T_map_center = around * grid_map_world::random_pose(random, 0.3, 0.2);
    window.cells_x = static_cast<int>(random() % 13);
    window.cells_y = random() % 10 == 0 ? 30 : static_cast<int>(random() % 13);
    window.headings = static_cast<int>(random() % 7);
    window.heading_step_rad = 0.005 + 0.1 * unit(random);
    const auto sigma = [&](double most) { return random() % 2 ? most * (0.01 + unit(random)) : INFINITY; };
    window.sigma_x_m = sigma(0.5);
    window.sigma_y_m = sigma(0.5);
    window.sigma_phi_rad = sigma(0.2);
}

void exclude_some(std::mt19937_64& random, const SearchResult& best, SearchWindow& window) {
    window.without = SearchWindow::Exclusion{best.dx_cells, best.dy_cells, best.heading,
                                             static_cast<int>(random() % 12), static_cast<int>(random() % 5)};
    if (random() % 4 == 0) window.without->heading = window.without->dx_cells = 1;
    if (random() % 2 == 0) window.also_without = {{-3, 2, -1, 3, 2}, {5, 0, 0, 20, 0}};
    if (random() % 2 == 0)
        for (int k = 0; k < (2 * window.cells_x + 1) * (2 * window.cells_y + 1); ++k)
            window.allowed.push_back(random() % 3 == 0);
}

void expect_same(const SearchCase& c, const std::optional<SearchResult>& naive) {
    const auto found = branch_and_bound(c.grid, c.points, c.window);
    ASSERT_EQ(found.has_value(), naive.has_value());
    if (!found) return;
    EXPECT_EQ(found->score, naive->score);
    EXPECT_EQ(found->dx_cells, naive->dx_cells);
    EXPECT_EQ(found->dy_cells, naive->dy_cells);
    EXPECT_EQ(found->heading, naive->heading);
    EXPECT_EQ(found->fit, naive->fit);
    EXPECT_EQ(found->T_map_base.x_m, naive->T_map_base.x_m);
    EXPECT_EQ(found->T_map_base.y_m, naive->T_map_base.y_m);
    EXPECT_EQ(found->T_map_base.phi_rad, naive->T_map_base.phi_rad);
}

TEST(BranchAndBound, finds_what_trying_all_places_finds) {
    std::mt19937_64 random(1);
    int found = 0, excluded = 0, refused = 0;
    for (int run = 0; run < 1000; ++run) {
        SCOPED_TRACE(run);
        SearchCase c;
        const Pose2 around = grid_map_world::random_pose(random, run % 2 ? 3 : 3000);
        const Kind kinds[] = {Kind::room,     Kind::corridor, Kind::clutter, Kind::room,
                              Kind::corridor, Kind::clutter,  Kind::empty};
        fill_map(random, kinds[run % 7], around, c);
        choose_window(random, around, c.window);
        if (run % 9 == 0) c.window.min_score = static_cast<int>(c.points.size() * (random() % 256));
        const auto best = exhaustive_search(c.grid, c.points, c.window);
        expect_same(c, best);
        if (HasFatalFailure()) return;
        (best ? found : refused)++;
        if (!best || run % 3 != 0) continue;
        exclude_some(random, *best, c.window);
        expect_same(c, exhaustive_search(c.grid, c.points, c.window));
        ++excluded;
    }
    // None of the kinds of case is missing.
    EXPECT_GT(found, 800);
    EXPECT_GT(excluded, 200);
    EXPECT_GT(refused, 20);
}

TEST(BranchAndBound, of_equal_places_takes_the_lowest_heading_then_y_then_x) {
    SearchWindow window;
    window.cells_x = 5;
    window.cells_y = 7;
    window.headings = 3;
    const ScanGrid empty({});
    const auto found = branch_and_bound(empty, {{1, 0}, {0, 1}}, window);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->dx_cells, -5);
    EXPECT_EQ(found->dy_cells, -7);
    EXPECT_EQ(found->heading, -3);
    EXPECT_EQ(found->score, 0);
}

TEST(BranchAndBound, finds_a_room_again_within_a_few_cells_and_heading_steps) {
    std::mt19937_64 random(2);
    const grid_map_world::Sensor sensor{361, 1.5 * M_PI, {0, 0, 0}, 0.01};
    for (int run = 0; run < 30; ++run) {
        const auto world = lines_world::random_world(random, 5, 2);
        ScanGrid grid({});
        for (int k = 0; k < 5; ++k) {
            const Pose2 T = grid_map_world::random_pose(random, 0.5);
            grid.insert(grid_map_world::frame_at(world, T, sensor, random), T);
        }
        const Pose2 truth = grid_map_world::random_pose(random, 0.5);
        SearchWindow window;
        window.cells_x = window.cells_y = 14;  // the corners of what is drawn are 0.64 m away
        window.T_map_center = truth * grid_map_world::random_pose(random, 0.45, 9 * M_PI / 180);
        const auto found = branch_and_bound(
            grid, search_points(grid_map_world::frame_at(world, truth, sensor, random), 100), window);
        ASSERT_TRUE(found);
        EXPECT_LT((found->T_map_base.translation() - truth.translation()).norm(), 0.15) << run;
        EXPECT_LT(std::abs(loopline::wrap_to_pi(found->T_map_base.phi_rad - truth.phi_rad)), 1 * M_PI / 180)
            << run;
    }
}

}  // namespace
