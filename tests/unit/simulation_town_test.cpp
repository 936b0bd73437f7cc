/// Towns, the ground below them, and paths that were recorded.
#include <gtest/gtest.h>

#include <cmath>

#include "simulation/mesh/mesh_caster.h"
#include "simulation/town/cubic_spline.h"
#include "simulation/town/recorded_path.h"
#include "simulation/town/spline_ground.h"
#include "simulation/town/terrain.h"
#include "simulation/town/town.h"
#include "support/run_program.h"
#include "support/simulated_scene.h"

using namespace loopline;
using namespace loopline::simulation;

namespace {

void expect_slope_is_the_derivative(const Ground& ground, RandomStream& random, double within_m) {
    constexpr double h = 1e-4;
    for (int i = 0; i < 50; ++i) {
        const Eigen::Vector2d p(random.uniform(-within_m, within_m), random.uniform(-within_m, within_m));
        const Eigen::Vector2d x(h, 0), y(0, h), slope = ground.slope(p);
        ASSERT_NEAR(slope.x(), (ground.height_m(p + x) - ground.height_m(p - x)) / (2 * h), 1e-6);
        ASSERT_NEAR(slope.y(), (ground.height_m(p + y) - ground.height_m(p - y)) / (2 * h), 1e-6);
        // A vehicle's forward and left axes are tangent to it, its height that of the ground.
        const Pose2 planar{p.x(), p.y(), random.uniform(-3, 3)};
        const Pose3 T_map_base = on_floor(planar, ground.below(planar));
        const Eigen::Vector3d normal = Eigen::Vector3d(-slope.x(), -slope.y(), 1).normalized();
        ASSERT_NEAR((T_map_base.rotation * Eigen::Vector3d::UnitZ() - normal).norm(), 0, 1e-9);
        ASSERT_NEAR(T_map_base.translation_m.z(), ground.height_m(p), 1e-12);
    }
}

/// A square of streets, driven once and a bit, with heights that drift.
std::vector<Pose3> square_path(double drift_a_lap_m) {
    std::vector<Pose3> poses;
    for (int i = 0; i < 500; ++i) {
        const double way_m = i, side = std::fmod(way_m / 100, 4), along_m = std::fmod(way_m, 100);
        const double x[] = {along_m, 100, 100 - along_m, 0}, y[] = {0, along_m, 100, 100 - along_m};
        const auto k = static_cast<std::size_t>(side);
        poses.emplace_back(Eigen::Vector3d(x[k], y[k], 0.01 * x[k] + drift_a_lap_m * i / 400),
                           Eigen::Quaterniond(Eigen::AngleAxisd(static_cast<double>(k) * M_PI / 2,
                                                                Eigen::Vector3d::UnitZ())));
    }
    return poses;
}

Street square_street() {
    std::vector<Eigen::Vector2d> points_m;
    for (const Pose3& pose : square_path(0)) points_m.push_back(pose.translation_m.head<2>());
    return Street(points_m);
}

}  // namespace

TEST(CubicSpline, passes_through_its_values_and_is_smooth) {
    std::vector<double> values{0, 1, -2, 3, 3, 3.5, -1};
    const CubicSpline<double> spline(values);
    for (std::size_t i = 0; i < values.size(); ++i)
        EXPECT_NEAR(spline.at(static_cast<double>(i)), values[i], 1e-12);
    constexpr double h = 1e-4;
    const auto second = [&](double u) {
        return (spline.at(u + h) - 2 * spline.at(u) + spline.at(u - h)) / (h * h);
    };
    for (int i = 1; i < 6; ++i) EXPECT_NEAR(second(i - 2 * h), second(i + 2 * h), 0.05) << i;
    EXPECT_NEAR(second(0.0 + 2 * h), 0, 0.05);
}

TEST(Terrain, slope_is_its_derivative_and_ramps_rise) {
    TerrainSettings settings;
    settings.sigma_slope_rad = 0.03;
    settings.sigma_rough_rad = 0.01;
    settings.ramps = {{-20, 0, 20, 0, 4}};
    const Terrain terrain(settings, Pose2{}, 5);
    RandomStream random(1, "places");
    expect_slope_is_the_derivative(terrain, random, 60);
    EXPECT_NEAR(terrain.height_m({0, 0}), 0, 1e-12);
    settings.sigma_slope_rad = settings.sigma_rough_rad = 0;
    const Terrain ramp(settings, Pose2{}, 5);
    EXPECT_NEAR(ramp.height_m({30, 7}) - ramp.height_m({-30, -7}), 4, 1e-12);
}

TEST(SplineGround, passes_below_a_path_and_is_smooth) {
    std::vector<Eigen::Vector3d> points_m;
    for (int i = 0; i < 400; ++i) {
        const double x = i * 0.5 - 100;
        for (const double y : {-1.5, 0.0, 1.5}) points_m.emplace_back(x, y, 2 * std::sin(x / 25) + 0.05 * y);
    }
    const SplineGround ground(points_m, 60);
    double worst_m = 0;
    for (const auto& p : points_m)
        worst_m = std::max(worst_m, std::abs(ground.height_m(p.head<2>()) - p.z()));
    EXPECT_LT(worst_m, 0.02);
    RandomStream random(1, "places");
    expect_slope_is_the_derivative(ground, random, 100);
}

TEST(RecordedPath, heights_agree_where_it_comes_back_to_a_place) {
    const auto before = square_path(2);
    auto poses = before;
    level_revisits(poses);
    for (std::size_t i = 410; i < 490; ++i)
        EXPECT_NEAR(poses[i].translation_m.z(), poses[i - 400].translation_m.z(), 0.12) << i;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        ASSERT_EQ(poses[i].translation_m.head<2>(), before[i].translation_m.head<2>());
        ASSERT_EQ(poses[i].rotation.coeffs(), before[i].rotation.coeffs());
    }
    EXPECT_EQ(poses[0].translation_m, before[0].translation_m);
}

TEST(RecordedPath, is_turned_from_the_cameras_axes) {
    test::TemporaryFolder folder;
    // 2 m ahead, 1 m to the right, 0.5 m down, turned right by a right angle: the camera's z axis lies along
    // its first x.
    const std::string file = folder.write("00.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 1 1 0 1 0 0.5 -1 0 0 2\n");
    const auto poses = read_kitti_poses(file);
    ASSERT_EQ(poses.size(), 2u);
    EXPECT_NEAR((poses[1].translation_m - Eigen::Vector3d(2, -1, -0.5)).norm(), 0, 1e-12);
    EXPECT_NEAR(poses[1].yaw_rad(), -M_PI / 2, 1e-9);
    EXPECT_THROW(read_kitti_poses((folder / "01.txt").string()), std::runtime_error);
    EXPECT_THROW(read_kitti_poses(folder.write("02.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 2 3\n")),
                 std::runtime_error);
}

TEST(RecordedPath, the_motion_passes_through_every_pose_in_time) {
    RandomStream random(3, "poses");
    std::vector<Pose3> poses;
    Pose3 pose;
    for (int i = 0; i < 60; ++i) {
        poses.push_back(pose);
        pose = pose *
               Pose3({1 + random.normal(0.05), random.normal(0.02), random.normal(0.02)},
                     Eigen::Quaterniond(Eigen::AngleAxisd(random.normal(0.05), Eigen::Vector3d::UnitZ()) *
                                        Eigen::AngleAxisd(random.normal(0.02), Eigen::Vector3d::UnitX())));
    }
    const TrueMotion motion = motion_through(poses, 10, 5'000'000);
    EXPECT_EQ(motion.duration_ns(), 5'995'000'000);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const Pose3 at = motion.pose_at(static_cast<StampNs>(i) * 100'000'000);
        ASSERT_NEAR((at.translation_m - poses[i].translation_m).norm(), 0, 1e-9);
        ASSERT_NEAR(at.rotation.angularDistance(poses[i].rotation), 0, 1e-7);
    }
}

TEST(Town, keeps_off_the_way_and_off_itself) {
    const Street street = square_street();
    const Terrain ground({}, Pose2{}, 1);
    const Town town = grow_town(street, street, ground, {}, 1);
    EXPECT_GT(town.buildings, 20u);
    const auto& lots = town.lots.taken();
    EXPECT_GT(lots.size(), 80u);
    for (std::size_t i = 0; i < lots.size(); ++i) {
        double least_m = 1e9;
        for (double way_m = 0; way_m <= street.length_m(); way_m += 1)
            least_m = std::min(least_m, distance_m(lots[i], street.at(way_m).translation()));
        ASSERT_GE(least_m, i < town.buildings ? 5.9 : 1.9) << i;
        for (std::size_t j = 0; j < i; ++j) ASSERT_FALSE(overlap(lots[i], lots[j]));
    }
}

TEST(Town, stands_where_it_stood_with_other_cars) {
    const Street street = square_street();
    const Terrain ground({}, Pose2{}, 1);
    const Town before = grow_town(street, street, ground, {}, 1),
               after = grow_town(street, street, ground, {}, {1, 2});
    const auto& lots = after.lots.taken();
    std::size_t again = 0, cars = 0;
    for (const Footprint& was : before.lots.taken()) {
        const bool is_there = std::any_of(lots.begin(), lots.end(), [&](const Footprint& is) {
            return is.T_map_middle.translation() == was.T_map_middle.translation();
        });
        const bool is_car = was.width_m > 1.4 && was.width_m < 2.6 && was.length_m > 3.5;
        cars += is_car ? 1 : 0;
        again += is_there ? 1 : 0;
        EXPECT_FALSE(is_car && is_there);
    }
    EXPECT_EQ(before.buildings, after.buildings);
    EXPECT_GT(cars, 20U);
    // All the others, but for the few that a car stands in the place of.
    EXPECT_GT(again, 0.95 * double(before.lots.taken().size() - cars));
}

TEST(Town, is_that_of_its_seed) {
    const Street street = square_street();
    const Terrain ground({}, Pose2{}, 1);
    const auto a = grow_town(street, street, ground, {}, 1).mesh,
               b = grow_town(street, street, ground, {}, 1).mesh,
               c = grow_town(street, street, ground, {}, 2).mesh;
    EXPECT_EQ(a.vertices_m, b.vertices_m);
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_NE(a.vertices_m, c.vertices_m);
}

TEST(Solids, rectangles_that_touch_are_told_apart) {
    const Footprint a{Pose2{0, 0, 0}, 4, 2};
    EXPECT_TRUE(overlap(a, {Pose2{2.9, 1.9, 0}, 2, 2}));
    EXPECT_FALSE(overlap(a, {Pose2{3.1, 0, 0}, 2, 2}));
    EXPECT_FALSE(overlap(a, {Pose2{2.8, 1.8, M_PI / 4}, 2, 2})) << "a corner turned away";
    EXPECT_NEAR(distance_m(a, {5, 5}), std::hypot(3, 4), 1e-12);
    EXPECT_EQ(distance_m(a, {1, -0.5}), 0);
}

TEST(Traffic, cars_move_without_leaps_and_meet_nothing) {
    const auto scene = test::scene_of(test::dataset("straight_street.ini"),
                                      {"town.ground_cell_m=20", "traffic.oncoming_s=6", "traffic.ahead=0.5"});
    const Traffic& traffic = scene->landscape->traffic;
    ASSERT_GT(traffic.meshes().size(), 5u);
    std::vector<std::optional<Eigen::Vector3d>> before(traffic.meshes().size());
    std::size_t seen = 0;
    for (StampNs time_ns = 0; time_ns < scene->duration_ns(); time_ns += 100'000'000) {
        const Pose3 T_map_base = scene->drive.motion.pose_at(time_ns);
        std::vector<std::optional<Eigen::Vector3d>> now(before.size());
        for (const MovingBody& body : traffic.at(time_ns)) {
            const Eigen::Vector3d& at_m = body.T_map_body.translation_m;
            now[body.mesh] = at_m;
            ++seen;
            ASSERT_GT((at_m - T_map_base.translation_m).norm(), 2.4);
            ASSERT_NEAR(at_m.z(), scene->landscape->ground->height_m(at_m.head<2>()), 1e-9);
            ASSERT_TRUE(scene->landscape->town.lots.is_free({body.T_map_body.planar(), 3.7, 1.6}));
            ASSERT_LT((at_m - before[body.mesh].value_or(at_m)).norm(), 2);
        }
        before = now;
    }
    EXPECT_GT(seen, 500u);
}

TEST(Traffic, cars_stand_until_the_vehicle_is_near_then_leave_and_meet_nothing) {
    const auto scene = test::scene_of(
        test::dataset("straight_street.ini"),
        {"town.ground_cell_m=20", "traffic.oncoming_s=0", "traffic.ahead=0", "traffic.standing_per_km=30"});
    const Traffic& traffic = scene->landscape->traffic;
    ASSERT_GT(traffic.meshes().size(), 8u);
    std::vector<Eigen::Vector3d> stood_at(traffic.meshes().size(), Eigen::Vector3d::Zero());
    std::vector<double> driven_m(stood_at.size(), 0), nearest_m(stood_at.size(), 1e9);
    for (const MovingBody& body : traffic.at(0)) stood_at[body.mesh] = body.T_map_body.translation_m;
    for (StampNs time_ns = 0; time_ns < scene->duration_ns(); time_ns += 100'000'000) {
        const Pose3 T_map_base = scene->drive.motion.pose_at(time_ns);
        for (const MovingBody& body : traffic.at(time_ns)) {
            const Eigen::Vector3d& at_m = body.T_map_body.translation_m;
            const double to_vehicle_m = (at_m - T_map_base.translation_m).norm();
            ASSERT_GT(to_vehicle_m, 2.4);
            const double moved_m = (at_m - stood_at[body.mesh]).norm();
            if (moved_m < 1e-6) nearest_m[body.mesh] = std::min(nearest_m[body.mesh], to_vehicle_m);
            ASSERT_LT(moved_m - driven_m[body.mesh], 1.5);
            driven_m[body.mesh] = moved_m;
        }
    }
    for (std::size_t car = 0; car < stood_at.size(); ++car) {
        EXPECT_LT(nearest_m[car], 50) << car;
        // Unless the drive ends before.
        if (stood_at[car].x() < 900) {
            EXPECT_GT(driven_m[car], 30) << car;
        }
    }
}

TEST(Gallery, closes_over_the_way) {
    const auto scene = test::scene_of(test::dataset("ramp_gallery.ini"));
    const Landscape& landscape = *scene->landscape;
    const auto caster = make_mesh_caster(landscape.town.mesh);
    std::vector<MeshRay> rays;
    for (const double way_m : {20.0, 70.0, 100.0, 140.0, 190.0}) {
        const Eigen::Vector2d p = landscape.driven.at(way_m).translation();
        rays.push_back({{p.x(), p.y(), landscape.ground->height_m(p) + 1}, Eigen::Vector3d::UnitZ()});
        rays.push_back({rays.back().origin_m, -Eigen::Vector3d::UnitZ()});
    }
    std::vector<MeshHit> hits;
    caster->cast(rays, 200, hits);
    for (std::size_t i = 0; i < 5; ++i) {
        const bool inside = i > 0 && i < 4;
        EXPECT_EQ(std::isfinite(hits[2 * i].range_m), inside) << i;
        EXPECT_TRUE(!inside || std::abs(hits[2 * i].range_m - 3.5) < 0.3) << i;
        EXPECT_NEAR(hits[2 * i + 1].range_m, 1, 0.05) << "the triangles of the ground lie on it";
    }
}

TEST(Tunnel, nothing_in_it_tells_how_far_one_has_come) {
    const auto scene = test::scene_of(test::dataset("tunnel.ini"), {"town.ground_cell_m=20"});
    const Landscape& landscape = *scene->landscape;
    const auto caster = make_mesh_caster(landscape.town.mesh);
    const auto hits_at = [&](double way_m) {
        const Pose2 T_map_way = landscape.driven.at(way_m);
        const Eigen::Vector2d p = T_map_way.translation();
        std::vector<MeshRay> rays;
        for (int azimuth_deg = 0; azimuth_deg < 360; azimuth_deg += 3)
            for (int elevation_deg = -30; elevation_deg <= 10; elevation_deg += 5) {
                const double a = T_map_way.phi_rad + azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;
                rays.push_back({{p.x(), p.y(), landscape.ground->height_m(p) + 1.73},
                                {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)}});
            }
        std::vector<MeshHit> hits;
        caster->cast(rays, 120, hits);
        return hits;
    };
    const auto here = hits_at(310);
    std::size_t returns = 0;
    for (const double way_m : {400.0, 530.0, 531.7, 700.0, 750.0}) {
        const auto there = hits_at(way_m);
        for (std::size_t i = 0; i < here.size(); ++i) {
            ASSERT_EQ(std::isfinite(here[i].range_m), std::isfinite(there[i].range_m)) << way_m << " " << i;
            if (!std::isfinite(here[i].range_m)) continue;
            ++returns;
            // Corners of triangles are of single precision; a lidar counts 2 mm.
            ASSERT_NEAR(here[i].range_m, there[i].range_m, 1e-3) << way_m << " " << i;
        }
    }
    EXPECT_GT(returns, 4000u);
    const auto outside = hits_at(100);
    EXPECT_TRUE(std::any_of(outside.begin(), outside.end(),
                            [](const auto& hit) { return !std::isfinite(hit.range_m); }));
    // A minute of the drive has no satellites.
    double hidden_s = 0;
    for (StampNs t = 0; t < scene->duration_ns(); t += 100'000'000) {
        const Eigen::Vector2d p = scene->drive.motion.planar_pose_at(t).translation();
        double least_m = 1e9;
        for (double way_m = 170; way_m <= 890; way_m += 1)
            least_m = std::min(least_m, (landscape.driven.at(way_m).translation() - p).norm());
        hidden_s += least_m < 1 ? 0.1 : 0;
    }
    EXPECT_NEAR(hidden_s, 61, 6);
}
