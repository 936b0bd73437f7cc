/// The point map: points where they are in space, one a cube.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "api/mrpt_pose.h"
#include "maps/points_module.h"
#include "maps_test_support.h"

using namespace loopline;
using namespace maps_test;
using mrpt::maps::CSimplePointsMap;
using mrpt::poses::CPose3D;

namespace {

std::vector<Eigen::Vector3d> points_of(const CSimplePointsMap& map) {
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < map.size(); ++i) {
        float x = 0, y = 0, z = 0;
        map.getPoint(i, x, y, z);
        points.emplace_back(x, y, z);
    }
    return points;
}

std::array<long, 3> cube_of(const Eigen::Vector3d& p, double edge_m) {
    return {std::lround(std::floor(p.x() / edge_m)), std::lround(std::floor(p.y() / edge_m)),
            std::lround(std::floor(p.z() / edge_m))};
}

/// A tilted vehicle with a tilted scanner, at random places.
struct World {
    Trajectory trajectory;
    std::vector<StreamItem> items;
    std::vector<Eigen::Vector3d> returns;

    World() {
        std::mt19937_64 random(3);
        std::uniform_real_distribution<double> way(-20, 20), angle(-1, 1);
        for (std::uint64_t i = 0; i < 30; ++i) {
            const CPose3D T_map_base(way(random), way(random), way(random), angle(random), angle(random),
                                     angle(random));
            const auto scan = scan_of(sparse_ranges(361, 2, random), 1.5 * M_PI,
                                      CPose3D(0.3, 0.1, 1, 2, 0.4, -0.7), i % 2 == 0);
            trajectory.append(i, 0, pose3_from_mrpt(T_map_base), Matrix6d::Zero());
            items.push_back(item_of(i, scan));
            const auto points = points_in_map(*scan, T_map_base);
            returns.insert(returns.end(), points.begin(), points.end());
        }
    }

    CSimplePointsMap::Ptr draw(const std::string& spacing, Results& results,
                               const std::string& limit = "1000000") const {
        PointsMapBuilder builder;
        set(builder, "spacing_m", spacing);
        set(builder, "max_points", limit);
        builder.start({}, trajectory);
        for (const auto& item : items) builder.insert(item);
        builder.finish(results);
        return only_map<CSimplePointsMap>(results);
    }
};

}  // namespace

TEST(MapsPoints, fine_spacing_keeps_every_return_in_its_place_in_space) {
    const World world;
    Results results;
    const auto points = points_of(*world.draw("0.001", results));
    ASSERT_EQ(points.size(), world.returns.size());
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT((points[i] - world.returns[i]).norm(), 2e-5);
}

TEST(MapsPoints, thinning_keeps_the_first_point_of_every_cube) {
    const World world;
    Results results;
    const auto points = points_of(*world.draw("4", results));
    std::set<std::array<long, 3>> taken;
    std::vector<Eigen::Vector3d> expected;  // by brute force
    for (const auto& p : world.returns)
        if (taken.insert(cube_of(p, 4)).second) expected.push_back(p);
    ASSERT_EQ(points.size(), expected.size());
    EXPECT_LT(points.size(), world.returns.size() / 2);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT((points[i] - expected[i]).norm(), 2e-5);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("points")), static_cast<std::int64_t>(points.size()));
}

TEST(MapsPoints, the_limit_holds_and_what_it_cost_is_told) {
    const World world;
    Results results;
    EXPECT_EQ(world.draw("0.001", results, "100")->size(), 100u);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("points_left_out")),
              static_cast<std::int64_t>(world.returns.size()) - 100);
}

TEST(MapsPoints, absurd_poses_and_far_returns_give_no_point) {
    Trajectory trajectory;
    trajectory.append(1, 0, Pose3(Pose2{std::numeric_limits<double>::infinity(), 0, 0}), Matrix6d::Zero());
    trajectory.append(2, 0, Pose3(Pose2{1e9, 0, 0}), Matrix6d::Zero());
    trajectory.append(3, 0, Pose3(Pose2{0, 0, 0}), Matrix6d::Zero());
    PointsMapBuilder builder;
    set(builder, "max_range_m", "10");
    builder.start({}, trajectory);
    for (std::uint64_t i = 1; i <= 4; ++i) builder.insert(item_of(i, scan_of({5, 20, 0}, M_PI)));
    Results results;
    builder.finish(results);
    const auto points = points_of(*only_map<CSimplePointsMap>(results));
    ASSERT_EQ(points.size(), 1u);
    EXPECT_LT((points[0] - Eigen::Vector3d(0, -5, 0)).norm(), 1e-5);
}
