/// A map from which scans are taken out is the map that never had them, and its likelihood is what the header
/// says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "property/grid_map_world.h"

using namespace loopline::grid_map;
using grid_map_world::random_frame;
using grid_map_world::random_pose;
using loopline::Pose2;

namespace {

struct PlacedFrame {
    Frame frame;
    Pose2 T_map_base;
};

/// Rooms that overlap, so that cells have many returns and lose some of them; now and then a frame twice.
std::vector<PlacedFrame> placed_frames(std::mt19937_64& random, const Pose2& around) {
    std::vector<PlacedFrame> all;
    const auto world = lines_world::random_world(random, 5, 2);
    for (int k = 0; k < 6; ++k) {
        const Pose2 T = random_pose(random, 0.5);
        all.push_back(
            {grid_map_world::frame_at(world, T, {181, M_PI, {0.2, 0, 0}, 0.02}, random), around * T});
    }
    for (int k = 0; k < 4; ++k) all.push_back({random_frame(random, 60, 3), around * random_pose(random, 2)});
    all.push_back(all[1]);
    return all;
}

TEST(ScanGrid, without_some_frames_is_the_grid_that_never_had_them) {
    std::mt19937_64 random(1);
    for (int run = 0; run < 20; ++run) {
        SCOPED_TRACE(run);
        ScanGridSettings settings;
        settings.free_space = run % 2 == 0;
        auto frames = placed_frames(random, random_pose(random, run % 3 == 0 ? 2000.0 : 1.0));
        ScanGrid grid(settings), never(settings);
        std::shuffle(frames.begin(), frames.end(), random);
        for (const auto& f : frames) grid.insert(f.frame, f.T_map_base);
        std::shuffle(frames.begin(), frames.end(), random);
        const std::size_t removed = random() % (frames.size() + 1);
        for (std::size_t k = 0; k < removed; ++k) {
            grid.remove(frames[k].frame, frames[k].T_map_base);
            if (random() % 3 == 0) grid.settle();
        }
        grid.settle();
        std::shuffle(frames.begin() + static_cast<std::ptrdiff_t>(removed), frames.end(), random);
        for (std::size_t k = removed; k < frames.size(); ++k)
            never.insert(frames[k].frame, frames[k].T_map_base);
        EXPECT_TRUE(grid == never);
        // It stays so when frames come back, and when others went before it was settled.
        for (std::size_t k = 0; k < removed; ++k) {
            grid.insert(frames[k].frame, frames[k].T_map_base);
            never.insert(frames[k].frame, frames[k].T_map_base);
        }
        EXPECT_TRUE(grid == never);
        grid.remove(frames.back().frame, frames.back().T_map_base);
        EXPECT_FALSE(grid == never);
        grid.insert(frames.back().frame, frames.back().T_map_base);
        grid.settle();
        EXPECT_TRUE(grid == never);
    }
}

TEST(ScanGrid, gives_memory_back_when_all_is_taken_out) {
    std::mt19937_64 random(2);
    const auto frames = placed_frames(random, {-3, 40, 1});
    ScanGrid grid({});
    const std::size_t empty = grid.bytes();
    for (const auto& f : frames) grid.insert(f.frame, f.T_map_base);
    const std::size_t full = grid.bytes();
    for (const auto& f : frames) grid.remove(f.frame, f.T_map_base);
    grid.settle();
    EXPECT_TRUE(grid == ScanGrid({}));
    grid.drop_empty_tiles();
    EXPECT_GT(full, empty);
    EXPECT_EQ(grid.bytes(), empty);
    grid.insert(frames[0].frame, frames[0].T_map_base);
    ScanGrid one({});
    one.insert(frames[0].frame, frames[0].T_map_base);
    EXPECT_TRUE(grid == one);
    EXPECT_EQ(grid.bytes(), one.bytes());
}

/// Level 0 as its definition has it: 255 exp(-d^2 / 2) of the nearest return, up to three cells away along
/// each axis.
int naive_likelihood(const ScanGrid& grid, int x, int y) {
    int best = 0;
    for (int dy = -3; dy <= 3; ++dy)
        for (int dx = -3; dx <= 3; ++dx) {
            const Surface surface = grid.surfaces().value(x + dx, y + dy);
            if (surface.returns > 0)
                best =
                    std::max(best, static_cast<int>(std::lround(255 * std::exp(-0.5 * (dx * dx + dy * dy)))));
        }
    return best;
}

void expect_levels_as_defined(const ScanGrid& grid, const Pose2& around, double reach_m) {
    const CellIndex middle = grid.cell_of(around.x_m, around.y_m);
    const int reach = static_cast<int>(reach_m / grid.cell_m()) + 70, side = 2 * reach + 1;
    std::vector<int> level_0(static_cast<std::size_t>(side * side));
    const auto at = [&](int x, int y) -> int& {
        return level_0[static_cast<std::size_t>((y - middle.y + reach) * side + x - middle.x + reach)];
    };
    const auto inside = [&](int x, int y) {
        return std::abs(x - middle.x) <= reach && std::abs(y - middle.y) <= reach;
    };
    int wrong = 0;
    for (int y = middle.y - reach; y <= middle.y + reach; ++y)
        for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
            at(x, y) = naive_likelihood(grid, x, y);
            wrong += grid.likelihood(0, x, y) != at(x, y);
        }
    EXPECT_EQ(wrong, 0) << "level 0";
    for (int level = 1; level < ScanGrid::levels; ++level) {
        const int size = 1 << level;
        for (int y = (middle.y - reach) >> level; y <= (middle.y + reach) >> level; ++y)
            for (int x = (middle.x - reach) >> level; x <= (middle.x + reach) >> level; ++x) {
                int best = 0;
                for (int cy = y * size; cy < (y + 2) * size; ++cy)
                    for (int cx = x * size; cx < (x + 2) * size; ++cx)
                        if (inside(cx, cy)) best = std::max(best, at(cx, cy));
                wrong += grid.likelihood(level, x, y) != best;
            }
        EXPECT_EQ(wrong, 0) << "level " << level;
    }
}

TEST(ScanGrid, likelihood_is_as_defined_at_all_levels) {
    std::mt19937_64 random(3);
    const Pose2 places[] = {{0, 0, 0}, {-7.3, -11.9, 1}, {812.31, -0.4, -2}};
    for (const Pose2& around : places) {
        SCOPED_TRACE(around.x_m);
        ScanGrid grid({});
        std::vector<PlacedFrame> frames;
        for (int k = 0; k < 4; ++k)
            frames.push_back({random_frame(random, 40, 2), around * random_pose(random, 1)});
        for (const auto& f : frames) grid.insert(f.frame, f.T_map_base);
        expect_levels_as_defined(grid, around, 4.5);
        for (int k = 0; k < 3; ++k)
            grid.remove(frames[static_cast<std::size_t>(k)].frame,
                        frames[static_cast<std::size_t>(k)].T_map_base);
        grid.settle();
        expect_levels_as_defined(grid, around, 4.5);
    }
}

TEST(ScanGrid, memory_grows_with_what_was_seen_and_not_with_how_far_apart_it_lies) {
    std::mt19937_64 random(4);
    const Frame frame = random_frame(random, 200, 3);
    ScanGrid here({}), near({}), far({});
    here.insert(frame, {});
    near.insert(frame, {});
    near.insert(frame, {30, 0, 0});
    far.insert(frame, {});
    far.insert(frame, {7000, -7000, 0});
    EXPECT_LT(far.bytes(), 2.5 * static_cast<double>(here.bytes()));
    EXPECT_LT(far.bytes(), 1.5 * static_cast<double>(near.bytes()));
    EXPECT_TRUE(far.surfaces().value(far.cell_of(3500, -3500).x, far.cell_of(3500, -3500).y) == Surface{});
}

TEST(ScanGrid, beams_pass_the_cells_between_sensor_and_return) {
    Frame frame;
    frame.points.push_back({{1.01F, 0.51F}, {0, 0}});
    ScanGrid grid({});
    grid.insert(frame, {-0.02, -0.02, 0});
    // Every cell that the beam crosses by more than a hair has a pass; none that it does not touch has one.
    const Eigen::Vector2d from(-0.02, -0.02), to(0.99, 0.49);
    std::map<std::pair<int, int>, bool> crossed;
    for (int k = 0; k <= 100000; ++k) {
        const Eigen::Vector2d p = from + (to - from) * (k / 100000.0);
        const CellIndex c = grid.cell_of(p.x(), p.y());
        crossed[{c.x, c.y}] = true;
    }
    const CellIndex last = grid.cell_of(to.x(), to.y());
    int passes = 0;
    grid.passes().for_each([&](int x, int y, std::int32_t count) {
        if (count == 0) return;
        ++passes;
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(crossed.count({x, y}));
    });
    EXPECT_EQ(passes, static_cast<int>(crossed.size()) - 1);
    EXPECT_EQ(grid.passes().value(last.x, last.y), 0);
}

}  // namespace
