/// Which lines could be near: never one too few, against looking at all of them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "line_slam/line_grid.h"

using namespace loopline::line_slam;

namespace {

TEST(LineGrid, finds_every_line_that_crosses_the_box) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> place(-60, 60), way(-25, 25);
    LineGrid grid;
    std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> stretches;
    for (int id = 0; id < 400; ++id) {
        const Eigen::Vector2d a(place(random), place(random)),
            b = a + Eigen::Vector2d(way(random), way(random));
        stretches.emplace_back(a, b);
        grid.add(id, a, b);
    }
    std::size_t found_in_all = 0;
    for (int i = 0; i < 100; ++i) {
        const Eigen::Vector2d least(place(random), place(random)), greatest = least + Eigen::Vector2d(15, 6);
        const std::vector<int> found = grid.in_box(least, greatest);
        EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
        found_in_all += found.size();
        for (int id = 0; id < 400; ++id) {
            bool crosses = false;
            for (int k = 0; k <= 1000 && !crosses; ++k) {
                const auto& [a, b] = stretches[static_cast<std::size_t>(id)];
                crosses = Eigen::AlignedBox2d(least, greatest).contains(a + (b - a) * (k / 1000.0));
            }
            if (!crosses) continue;
            EXPECT_TRUE(std::binary_search(found.begin(), found.end(), id)) << id;
        }
    }
    EXPECT_LT(found_in_all, 100u * 100u) << "it should leave most out";
}

}  // namespace
