/// The cloud of a spinning lidar: each return at the pose of its own time, what a view looked through, and no
/// more memory on the second lap than on the first.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationRotatingScan.h>

#include <map>
#include <random>
#include <set>

#include "api/mrpt_pose.h"
#include "cloud_map/cloud_map_module.h"
#include "support/cloud_map_scans.h"
#include "support/run_program.h"

using namespace loopline;
using namespace loopline::cloud_map;
using namespace loopline::cloud_map_scans;

namespace {

RangeView view_of(const lidar::SpinningScan& scan) {
    SweepMotion motion;
    EXPECT_TRUE(motion.follow(scan, standing()));
    return RangeView(scan, motion);
}

}  // namespace

TEST(CloudMapPoses, motion_goes_on_before_the_first_pose_and_after_the_last_but_not_across_a_gap) {
    PoseWindow window(0.5);
    EXPECT_FALSE(window.at(0));
    const auto at_x = [](double x_m) { return Pose3({x_m, 0, 0}, Eigen::Quaterniond::Identity()); };
    const StampNs ms = 1'000'000;
    window.add({0, at_x(0)});
    window.add({100 * ms, at_x(1)});
    window.add({200 * ms, at_x(3)});
    window.add({900 * ms, at_x(20)});
    EXPECT_NEAR(window.at(50 * ms)->translation_m.x(), 0.5, 1e-9);
    EXPECT_NEAR(window.at(150 * ms)->translation_m.x(), 2, 1e-9);
    EXPECT_NEAR(window.at(-50 * ms)->translation_m.x(), -0.5, 1e-9);
    EXPECT_NEAR(window.at(250 * ms)->translation_m.x(), 4, 1e-9);
    EXPECT_NEAR(window.at(850 * ms)->translation_m.x(), 20, 1e-9);  // what moved it there nobody knows
    EXPECT_FALSE(window.at(-501 * ms));
    EXPECT_FALSE(window.at(1401 * ms));
    window.forget_before(150 * ms);
    EXPECT_NEAR(window.at(150 * ms)->translation_m.x(), 2, 1e-9);
}

TEST(CloudMapPoses, each_return_is_carried_by_the_pose_of_its_own_time) {
    const Twist3 velocity{{12, 0.3, -0.2}, {0.1, -0.2, 0.9}};  // a second
    const Pose3 T_base_lidar({0.5, 0.1, 1.7},
                             Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())));
    const Pose3 T_map_start(
        {5000, -3000, 40}, Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 9).normalized())));
    const auto true_pose = [&](double t_s) { return T_map_start * exp_se3(velocity * t_s); };
    PoseWindow window(0.5);
    for (const double t_s : {-0.1, 0.0, 0.1, 0.2})
        window.add({start_ns + std::llround(1e9 * t_s), true_pose(t_s)});
    auto scan = scan_of([](double, double a) { return 30 + 10 * std::sin(5 * a); });
    scan.T_base_lidar = T_base_lidar;
    SweepMotion motion;
    ASSERT_TRUE(motion.follow(scan, [&](StampNs t) { return window.at(t); }));
    for (std::size_t i = 0; i < scan.points.size(); i += 7) {
        const auto& p = scan.points[i];
        const Eigen::Vector3d exact =
            true_pose(p.time_s) * T_base_lidar * Eigen::Vector3d(p.x_m, p.y_m, p.z_m);
        ASSERT_LT((motion.p_map_m(p) - exact).norm(), 1e-4);
    }
}

TEST(CloudMapView, tells_what_it_looked_through_from_what_it_saw_and_what_was_hidden) {
    const RangeView view = view_of(scan_of([](double, double) { return 20; }));
    const ViewSettings settings;
    for (const double a : {0.1, 1.7, 3.1, -3.1, -0.7}) {
        const auto at = [&](float r) {
            return view.look(Eigen::Vector3f(r * static_cast<float>(std::cos(a)),
                                             r * static_cast<float>(std::sin(a)), -0.5f),
                             settings);
        };
        EXPECT_EQ(at(12), Evidence::through);
        EXPECT_EQ(at(20), Evidence::seen);
        EXPECT_EQ(at(25), Evidence::none);
    }
    EXPECT_EQ(view.look({0.5f, 0, 5}, settings), Evidence::none);  // above all beams
}

TEST(CloudMapView, spares_the_ground_at_a_grazing_angle_though_poses_are_wrong) {
    constexpr double height_m = 1.8;
    const RangeView view =
        view_of(scan_of([](double e, double) { return e < -0.03 ? height_m / std::sin(-e) : 0; }));
    std::mt19937_64 random(5);
    std::uniform_real_distribution<float> x(-45, 45), error(-1, 1);
    int seen = 0;
    for (int i = 0; i < 20000; ++i) {
        Eigen::Vector3f p(x(random), x(random), -static_cast<float>(height_m) + 0.02f * error(random));
        p = Eigen::AngleAxisf(0.001f * error(random), Eigen::Vector3f::UnitY()) * p;
        const Evidence evidence = view.look(p, {});
        ASSERT_NE(evidence, Evidence::through) << p.transpose();
        seen += evidence == Evidence::seen ? 1 : 0;
    }
    EXPECT_GT(seen, 2000);
}

TEST(CloudMapView, spares_a_thin_post_though_most_beams_pass_beside_it) {
    // 12 cm at 15 m: one or two columns of 0.4 degrees, in front of a wall.
    const double half_rad = 0.06 / 15;
    const RangeView view =
        view_of(scan_of([&](double, double a) { return std::abs(a - 0.5) < half_rad ? 15.0 : 40.0; }));
    for (const float off_m : {-0.05f, 0.0f, 0.05f})
        for (const float z_m : {-3.0f, 0.1f, 1.0f}) {
            const Eigen::Vector3f post(15 * std::cos(0.5f), 15 * std::sin(0.5f), z_m);
            const Eigen::Vector3f across(-std::sin(0.5f), std::cos(0.5f), 0);
            EXPECT_NE(view.look(post + off_m * across, {}), Evidence::through);
        }
}

TEST(CloudMapTiles, hold_as_many_points_as_a_list_of_them_would_whatever_is_given_and_gone) {
    std::mt19937_64 random(11);
    TileStore store(0.1);
    std::map<std::array<std::int32_t, 3>, std::uint32_t> alive;  // voxel: time of its point
    std::uniform_int_distribution<int> voxel(-8, 8), what(0, 2);
    for (std::uint32_t round = 0; round < 200; ++round) {
        std::vector<CloudPoint> given;
        std::vector<std::uint64_t> gone;
        std::set<std::array<std::int32_t, 3>> met;
        for (int i = 0; i < 40; ++i) {
            const std::array<std::int32_t, 3> v{voxel(random), voxel(random), voxel(random) / 4};
            if (!met.insert(v).second) continue;
            if (alive.count(v) == 0) {
                CloudPoint point;
                for (std::size_t axis = 0; axis < 3; ++axis) point.place[axis] = v[axis] * 1000 + 400;
                point.time_ticks = round;
                given.push_back(point);
                alive[v] = round;
            } else if (what(random) > 0) {
                gone.push_back(pack(v));
                alive.erase(v);
            }
        }
        store.append({0, 0}, given, gone);
    }
    const auto check = [&](const auto& for_each) {
        std::map<std::array<std::int32_t, 3>, std::uint32_t> found;
        for_each([&](const CloudPoint& point) {
            EXPECT_TRUE(found.emplace(store.voxel_of(point), point.time_ticks).second);
        });
        EXPECT_EQ(found, alive);
    };
    check([&](const auto& use) { store.for_each_of({0, 0}, use); });
    store.leave_out_what_is_gone();
    check([&](const auto& use) {
        for (const CloudPoint& point : store.cloud().points()) use(point);
    });
    EXPECT_GT(alive.size(), 100u);
}

TEST(CloudMapTiles, come_back_with_the_points_that_they_had_when_they_were_put_away_last) {
    std::mt19937_64 random(12);
    std::uniform_int_distribution<unsigned> place(0, Block::voxels - 1), part(0, offset_parts - 1);
    std::uniform_int_distribution<int> block(-3, 3), many(0, 40);
    TileStore store(0.1);
    std::map<CubeIndex, std::map<unsigned, VoxelOffset>> taken[2];  // of two tiles
    Tile tiles[2];
    for (int round = 0; round < 20; ++round)
        for (const int t : {0, 1}) {
            Tile& tile = tiles[t];
            const CubeIndex index{block(random), block(random), block(random)};
            for (int k = many(random); k > 0; --k) {
                const unsigned voxel = place(random);
                VoxelOffset offset;
                for (auto& along : offset) along = static_cast<std::uint8_t>(part(random));
                if (taken[t][index].emplace(voxel, offset).second) tile.block(index).give(voxel, offset);
            }
            // One of them is gone.
            tile.block(index).look_again(
                [&](unsigned voxel, std::uint8_t&) { return voxel != taken[t][index].begin()->first; });
            if (!taken[t][index].empty()) taken[t][index].erase(taken[t][index].begin());
            store.put_away({t, 0}, tile);
            tile = {};
            store.bring_back({t, 0}, tile);
            for (const auto& [where, voxels] : taken[t]) {
                Block& there = tile.block(where);
                EXPECT_EQ(there.points_given(), voxels.size());
                for (unsigned voxel = 0; voxel < Block::voxels; ++voxel)
                    ASSERT_EQ(there.is_taken(voxel), voxels.count(voxel) == 1);
                for (const auto& [voxel, offset] : voxels) ASSERT_EQ(there.offset_of(voxel), offset);
            }
        }
}

TEST(CloudMapTiles, know_the_box_about_the_points_of_a_block_and_which_are_in_doubt) {
    std::mt19937_64 random(13);
    std::uniform_int_distribution<unsigned> place(0, Block::voxels - 1);
    std::uniform_int_distribution<int> many(1, 30), chance(0, 4);
    for (int round = 0; round < 200; ++round) {
        Block block;
        std::map<unsigned, int> doubt;  // of each place
        for (int k = many(random); k > 0; --k) doubt[place(random)] = 0;
        for (const auto& [voxel, zero] : doubt) block.give(voxel, {});
        for (int look = 0; look < 6 && !doubt.empty(); ++look) {
            std::array<int, 3> first{7, 7, 7}, last{0, 0, 0};
            for (const auto& [voxel, of_it] : doubt)
                for (unsigned axis = 0; axis < 3; ++axis) {
                    const int at = static_cast<int>(voxel >> (6 - 3 * axis) & 7);
                    first[axis] = std::min(first[axis], at);
                    last[axis] = std::max(last[axis], at);
                }
            EXPECT_EQ(block.box_of_given().first, first);
            EXPECT_EQ(block.box_of_given().last, last);
            std::map<unsigned, int> next;
            block.look_again([&](unsigned voxel, std::uint8_t& of_it) {
                EXPECT_EQ(of_it, doubt.at(voxel));
                if (chance(random) == 0) ++of_it;
                if (of_it < 2) next[voxel] = of_it;
                return of_it < 2;
            });
            const unsigned fresh = place(random);
            if (next.try_emplace(fresh, 0).second) block.give(fresh, {});
            doubt = next;
            bool any = false;
            for (const auto& [voxel, of_it] : doubt) any |= of_it > 0;
            EXPECT_EQ(block.is_doubted(), any);
            EXPECT_EQ(block.points_given(), doubt.size());
        }
    }
}

namespace {

/// A street between two rows of houses, round a square of 150 m, seen every 2 m.
struct SquareDrive {
    static constexpr int sweeps_per_lap = 300;

    static Pose3 pose(int k) {
        const double way_m = 2.0 * (k % sweeps_per_lap), side_m = 150;
        const int side = static_cast<int>(way_m / side_m);
        const double along_m = way_m - side * side_m, c[] = {0, side_m, side_m, 0},
                     s[] = {0, 0, side_m, side_m};
        const double a = side * M_PI / 2;
        return {{c[side] + along_m * std::cos(a), s[side] + along_m * std::sin(a), 1.8},
                Eigen::Quaterniond(Eigen::AngleAxisd(a, Eigen::Vector3d::UnitZ()))};
    }
    static lidar::SpinningScan scan(int k) {
        auto scan = scan_of(
            [](double e, double a) {
                const double to_wall_m = 8 / std::max(0.05, std::abs(std::sin(a)) * std::cos(e));
                const double to_ground_m = e < 0 ? 1.8 / std::sin(-e) : 1e9;
                return std::min({to_wall_m, to_ground_m, 60.0});
            },
            360);
        scan.stamp_ns = start_ns + 200'000'000LL * k;
        return scan;
    }
};

}  // namespace

TEST(CloudMapMemory, is_the_same_after_each_lap_and_so_is_the_map) {
    const test::TemporaryFolder folder;
    CloudMapSettings settings;
    settings.max_range_m = 25;
    settings.removal.views = 5;
    CloudMapper mapper(settings, 1);
    mapper.keep_in(folder.path(), "map");
    CloudMapCounts after_lap[3];
    std::size_t points_after_lap[3] = {0, 0, 0};
    for (int lap = 0; lap < 3; ++lap) {
        for (int k = 0; k < SquareDrive::sweeps_per_lap; ++k)
            mapper.add(SquareDrive::scan(lap * SquareDrive::sweeps_per_lap + k), {},
                       standing(SquareDrive::pose(k)));
        after_lap[lap] = mapper.counts();
        points_after_lap[lap] = mapper.cloud().points().size();
    }
    mapper.finish();
    // Tiles that were forgotten were found again, also by their neighbours.
    EXPECT_GT(nearest_two_m(mapper.cloud(), settings.voxel_m), settings.voxel_m - rounding_m);
    // Of a tile that comes back, those blocks too are there that were seen last when it was left before.
    EXPECT_LT(double(after_lap[1].most_blocks), 1.2 * double(after_lap[0].most_blocks));
    EXPECT_LT(double(after_lap[2].most_blocks), 1.002 * double(after_lap[1].most_blocks));
    EXPECT_EQ(after_lap[2].most_candidates, after_lap[0].most_candidates);
    // The end of the first lap was still held then; beyond that the second one finds nothing new.
    EXPECT_LT(double(mapper.cloud().points().size()), 1.12 * double(points_after_lap[0]));
    EXPECT_LT(double(after_lap[1].most_blocks * Block::voxels) / 40, double(points_after_lap[0]));
}

TEST(CloudMapModuleTest, maps_a_sweep_when_the_pose_after_it_has_come_and_says_how_many_had_none) {
    CloudMapModule module;
    module.start({});
    class Nobody : public Publisher {
        void publish(const mrpt::obs::CObservation::Ptr&) override {}
        void publish(const mrpt::obs::CObservation::Ptr&, std::uint64_t) override {}
    } nobody;
    lidar::RangeImageGeometry geometry;
    geometry.columns = 360;
    geometry.first_azimuth_rad = M_PI;
    geometry.azimuth_span_rad = -6.2;
    geometry.sweep_s = 0.1;
    geometry.range_unit_m = 0.01;
    geometry.elevations_deg = {1, 0, -1, -2};
    const auto take = [&](StampNs t, bool with_pose) {
        auto sweep = lidar::rotating_scan(geometry, "TEST", std::vector<std::uint16_t>(4 * 360, 1000));
        sweep->timestamp = stamp_to_mrpt(t);
        module.process({0, t, sweep, false}, nobody);
        if (!with_pose) return;
        auto pose = mrpt::obs::CObservationRobotPose::Create();
        pose->timestamp = sweep->timestamp;
        pose->sensorLabel = "lidar_mapping";
        module.process({0, t, pose, true}, nobody);
    };
    take(start_ns, true);
    take(start_ns + 100'000'000, true);
    take(start_ns + 60'000'000'000, false);  // long after the last pose
    Results results;
    module.finish(results);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("cloud_sweeps")), 2);
    EXPECT_EQ(std::get<std::int64_t>(results.metrics.at("cloud_sweeps_without_pose")), 1);
    EXPECT_GT(module.cloud()->points().size(), 300u);
    EXPECT_EQ(module.cloud()->first_ns, start_ns);
}
