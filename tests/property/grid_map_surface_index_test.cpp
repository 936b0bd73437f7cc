/// The surface near a place against a search through all points.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "grid_map/surface_index.h"

using namespace loopline::grid_map;
using loopline::Pose2;

namespace {

/// Straight from the description: nearest, and what continues it.
SurfaceIndex::Nearby by_all_points(const Frame& frame, const Eigen::Vector2d& p, const Eigen::Vector2d& n,
                                   double reach_m, double spacing_m) {
    const auto facing = [&](const SurfacePoint& q) { return q.normal_base.cast<double>().dot(n) > 0.7; };
    const SurfacePoint* nearest = nullptr;
    double nearest2 = reach_m * reach_m;
    for (const SurfacePoint& q : frame.points) {
        const double d2 = (q.p_base_m.cast<double>() - p).squaredNorm();
        if (d2 >= nearest2 || !facing(q)) continue;
        nearest2 = d2;
        nearest = &q;
    }
    SurfaceIndex::Nearby result;
    if (nearest == nullptr) return result;
    Eigen::Vector2d way(0, 0), normal(0, 0);
    double sum = 0;
    for (const SurfacePoint& q : frame.points) {
        const double d2 = (q.p_base_m.cast<double>() - p).squaredNorm();
        if (d2 >= reach_m * reach_m || !facing(q) || q.normal_base.dot(nearest->normal_base) < 0.8F) continue;
        const double part = std::max(0.0, 1 - (d2 - nearest2) / (8 * spacing_m * spacing_m)),
                     w = std::pow(part, 4);
        way += w * (q.p_base_m.cast<double>() - p);
        normal += w * q.normal_base.cast<double>();
        sum += w;
    }
    return {true, static_cast<float>(way.x() / sum), static_cast<float>(way.y() / sum),
            static_cast<float>(normal.x()), static_cast<float>(normal.y())};
}

TEST(SurfaceIndex, nearest_surface_equals_that_of_a_search_through_all_points) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> turn(-M_PI, M_PI);
    int found = 0;
    for (int run = 0; run < 40; ++run) {
        // Some crowded, some so wide that places far apart share slots, some across the origin's axes.
        const double half_m = run % 3 == 0 ? 0.5 : run % 3 == 1 ? 4 : 60;
        std::uniform_real_distribution<double> along(-half_m, half_m);
        Frame frame;
        for (int k = 0; k < 700; ++k) {
            SurfacePoint q;
            const double direction = turn(random);
            q.p_base_m = Eigen::Vector2d(along(random), along(random)).cast<float>();
            q.normal_base = Eigen::Vector2d(std::cos(direction), std::sin(direction)).cast<float>();
            frame.points.push_back(q);
        }
        SurfaceIndex index(0.2);
        for (int again = 0; again < 2; ++again) {
            index.clear();
            index.add(frame, Pose2{});
            index.finish();
        }
        for (int k = 0; k < 300; ++k) {
            const auto& near = frame.points[random() % frame.points.size()];
            const Eigen::Vector2d p =
                near.p_base_m.cast<double>() + 0.02 * Eigen::Vector2d(turn(random), turn(random));
            const double direction = turn(random);
            const Eigen::Vector2d n(std::cos(direction), std::sin(direction));
            const auto expected = by_all_points(frame, p, n, 0.15, 0.05);
            const auto nearby =
                index.nearest(p.x(), p.y(), static_cast<float>(n.x()), static_cast<float>(n.y()), 0.15F);
            ASSERT_EQ(nearby.found, expected.found);
            if (!nearby.found) continue;
            ++found;
            EXPECT_NEAR(nearby.dx_m, expected.dx_m, 2e-5);
            EXPECT_NEAR(nearby.dy_m, expected.dy_m, 2e-5);
            EXPECT_NEAR(nearby.nx, expected.nx, 2e-3);
            EXPECT_NEAR(nearby.ny, expected.ny, 2e-3);
        }
    }
    EXPECT_GT(found, 3000);
}

TEST(SurfaceIndex, of_nothing_finds_nothing) {
    SurfaceIndex index(0.2);
    index.finish();
    EXPECT_TRUE(index.empty());
    EXPECT_FALSE(index.nearest(0, 0, 1, 0, 0.15F).found);
}

}  // namespace
