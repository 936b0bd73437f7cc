/// Pushed carts: paths, speeds, the floor below, and the three worlds of carts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulation/clutter.h"
#include "simulation/encoders.h"
#include "simulation/pushed_drive.h"
#include "simulation/uneven_floor.h"
#include "support/simulated_scene.h"

using namespace loopline;
using namespace loopline::simulation;
using namespace loopline::test;

namespace {

const Waypoints corners{{0, 0}, {6, 0}, {6, 5}, {12, 5}, {18, 11}, {0, 11}, {0, 0}};
constexpr double cart_step_s = 0.005;

VehicleSettings perfect_wheels() {
    VehicleSettings vehicle;
    vehicle.slip_straight = vehicle.sigma_straight_m = 0;
    return vehicle;
}

Drive pushed(const PushSettings& push, std::uint64_t seed = 1, const VehicleSettings& vehicle = {}) {
    auto drive = push_along(corners, push, {}, vehicle, seed);
    if (!drive) throw std::runtime_error("it does not arrive");
    return std::move(*drive);
}

/// Planar poses at the steps of a drive.
std::vector<Pose2> poses_at_steps(const Drive& drive) {
    std::vector<Pose2> poses;
    for (StampNs t = 0; t <= drive.motion.duration_ns(); t += drive.motion.step_ns())
        poses.push_back(drive.motion.planar_pose_at(t));
    return poses;
}

std::vector<double> differences(const std::vector<double>& values) {
    std::vector<double> rates;
    for (std::size_t i = 1; i < values.size(); ++i)
        rates.push_back((values[i] - values[i - 1]) / cart_step_s);
    return rates;
}

double largest(const std::vector<double>& values) {
    double most = 0;
    for (const double value : values) most = std::max(most, std::abs(value));
    return most;
}

std::vector<std::string> seed_is(int seed) {
    return {"simulation.seed=" + std::to_string(seed)};
}

}  // namespace

TEST(CartPath, bends_join_the_legs_smoothly_and_are_no_tighter_than_asked) {
    const CartPath path(corners, 1);
    constexpr double step_m = 1e-3;
    double tightest_per_m = 0;
    PathPoint before = path.at(0);
    for (double way_m = step_m; way_m <= path.length_m(); way_m += step_m) {
        const PathPoint now = path.at(way_m);
        const Twist2 moved = log_se2(before.T_world_path.inverse() * now.T_world_path);
        ASSERT_NEAR(moved.forward_m, step_m, 1e-8) << way_m;
        ASSERT_NEAR(moved.left_m, 0, 1e-8);
        ASSERT_NEAR(moved.turn_rad / step_m, (before.curvature_per_m + now.curvature_per_m) / 2, 1e-5);
        ASSERT_LT(std::abs(now.curvature_per_m - before.curvature_per_m), 3 * step_m) << "no jump";
        tightest_per_m = std::max(tightest_per_m, std::abs(now.curvature_per_m));
        before = now;
    }
    EXPECT_NEAR(tightest_per_m, 1, 1e-5);
    EXPECT_LT((path.at(path.length_m()).T_world_path.translation() - corners.back()).norm(), 1e-9);
    EXPECT_NEAR(CartPath::sharpest_turn_rad(corners), 135 * M_PI / 180, 1e-12);
}

TEST(CartPath, short_legs_make_tighter_bends) {
    const Waypoints steps{{0, 0}, {1, 0}, {1, 1}, {2, 1}};
    const CartPath path(steps, 5);
    EXPECT_LT((path.at(path.length_m()).T_world_path.translation() - steps.back()).norm(), 1e-9);
    EXPECT_LT((path.at(path.length_m() / 2).T_world_path.translation() - Eigen::Vector2d(1, 0.5)).norm(),
              1e-9);
}

TEST(PushedCart, moves_without_jumps_of_speed_turn_rate_or_their_derivatives) {
    PushSettings push;
    push.stop_every_m = 12;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const auto poses = poses_at_steps(pushed(push, seed));
        std::vector<double> way_m{0}, heading_rad{0};
        for (std::size_t i = 1; i < poses.size(); ++i) {
            const Twist2 moved = log_se2(poses[i - 1].inverse() * poses[i]);
            way_m.push_back(way_m.back() + moved.forward_m);
            heading_rad.push_back(heading_rad.back() + moved.turn_rad);
            ASSERT_NEAR(moved.left_m, 0, 1e-6) << "it rolls where it points";
        }
        const auto speed = differences(way_m), acceleration = differences(speed),
                   jerk = differences(acceleration);
        EXPECT_GT(*std::min_element(speed.begin(), speed.end()), -1e-9);
        EXPECT_NEAR(largest(speed), 1, 0.35);
        EXPECT_LT(largest(acceleration), 1) << "m/s^2";
        EXPECT_LT(largest(jerk), 6) << "m/s^3";
        EXPECT_LT(largest(differences(jerk)), 60) << "m/s^4";
        const auto turn = differences(heading_rad), turning = differences(turn);
        EXPECT_LT(largest(turn), 65 * M_PI / 180);
        EXPECT_LT(largest(turning), 2.5) << "rad/s^2";
        EXPECT_LT(largest(differences(turning)), 15) << "rad/s^3";
    }
}

TEST(PushedCart, stands_still_at_the_start_at_stops_and_at_the_end) {
    PushSettings push;
    push.standstill_s = 6;
    push.end_standstill_s = 4;
    push.stop_every_m = 12;
    push.stop_s = 5;
    const Drive drive = pushed(push);
    const auto poses = poses_at_steps(drive);
    std::vector<double> pauses_s;
    for (std::size_t i = 1, still = 0; i < poses.size(); ++i) {
        still = (poses[i].translation() - poses[i - 1].translation()).norm() < 1e-12 ? still + 1 : 0;
        const bool ends =
            i + 1 == poses.size() || (poses[i + 1].translation() - poses[i].translation()).norm() >= 1e-12;
        if (ends && still > 20) pauses_s.push_back(static_cast<double>(still) * cart_step_s);
    }
    ASSERT_GE(pauses_s.size(), 4u);
    EXPECT_NEAR(pauses_s.front(), 6 - 0.5, 0.05) << "speeds are smoothed over 1 s";
    EXPECT_NEAR(pauses_s[1], 5 - 1, 0.1);
    EXPECT_NEAR(pauses_s.back(), 4 - 0.5, 0.05);
    EXPECT_EQ(drive.motion.planar_pose_at(0).x_m, 0);
    EXPECT_EQ(drive.motion.planar_pose_at(0).phi_rad, 0);
}

TEST(PushedCart, a_seed_repeats_its_drive_and_another_does_not) {
    const Drive a = pushed({}, 3), b = pushed({}, 3), c = pushed({}, 4);
    ASSERT_EQ(a.motion.duration_ns(), b.motion.duration_ns());
    for (StampNs t = 0; t < a.motion.duration_ns(); t += 77'000'000) {
        ASSERT_EQ(a.motion.planar_pose_at(t).x_m, b.motion.planar_pose_at(t).x_m);
        ASSERT_EQ(a.motion.planar_pose_at(t).phi_rad, b.motion.planar_pose_at(t).phi_rad);
    }
    EXPECT_NE(a.motion.last().x_m, c.motion.last().x_m);
}

TEST(PushedCart, hands_let_it_stray_as_far_as_asked) {
    PushSettings push;
    push.sigma_side_m = 0.03;
    const CartPath path(Waypoints{{0, 0}, {60, 0}}, 1);
    double sum2 = 0;
    int samples = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        const auto drive = push_along({{0, 0}, {60, 0}}, push, {}, {}, seed);
        for (StampNs t = 20'000'000'000; t < 50'000'000'000; t += 500'000'000, ++samples)
            sum2 += std::pow(drive->motion.planar_pose_at(t).y_m, 2);
    }
    EXPECT_NEAR(std::sqrt(sum2 / samples), 0.03, 0.003);
}

TEST(PushedCart, wheels_that_lose_nothing_tell_the_path) {
    const VehicleSettings vehicle = perfect_wheels();
    const Drive drive = pushed({}, 1, vehicle);
    EncoderSettings settings;
    settings.metres_per_tick_m = 0;
    settings.track_width_m = vehicle.track_width_m;
    Encoders encoders(settings, drive);
    const Pose2 reckoned = encoders.read(drive.motion.duration_ns()).T_odom_base;
    EXPECT_LT((reckoned.translation() - drive.motion.last().translation()).norm(), 1e-3);
    EXPECT_NEAR(wrap_to_pi(reckoned.phi_rad - drive.motion.last().phi_rad), 0, 1e-9);
}

TEST(PushedCart, slip_and_noise_of_its_wheels_are_those_asked_for) {
    VehicleSettings vehicle = perfect_wheels();
    vehicle.slip_straight = 0.01;
    vehicle.sigma_straight_m = 0.01;
    constexpr double way_m = 30;
    double sum_m = 0, sum2_m2 = 0;
    constexpr int drives = 60;
    for (int i = 0; i < drives; ++i) {
        const auto drive = push_along({{0, 0}, {way_m, 0}}, {}, {}, vehicle, static_cast<std::uint64_t>(i));
        const double difference_m = drive->rim_m.back().right - drive->rim_m.back().left;
        sum_m += drive->rim_m.back().right / drives;
        sum2_m2 += difference_m * difference_m / drives;
    }
    const double sigma_m = 0.01 * std::sqrt(way_m);
    EXPECT_NEAR(sum_m, way_m / 0.99, 5 * sigma_m / std::sqrt(drives) + 0.02);
    EXPECT_NEAR(std::sqrt(sum2_m2), std::sqrt(2.0) * sigma_m, 5 * sigma_m / std::sqrt(drives));
}

TEST(UnevenFloor, slopes_have_the_deviation_asked_for_and_tilt_what_stands_on_it) {
    const double sigma_rad = 0.3 * M_PI / 180;
    double sum2_pitch = 0, sum2_roll = 0;
    int samples = 0;
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        const UnevenFloor floor(sigma_rad, seed);
        EXPECT_EQ(floor.height_m({0, 0}), 0);
        for (int i = 0; i < 100; ++i, ++samples) {
            const Pose2 pose{0.37 * i, -0.71 * i, 0.3 * i};
            const FloorAttitude below = floor.below(pose);
            sum2_pitch += std::pow(below.pitch_rad, 2);
            sum2_roll += std::pow(below.roll_rad, 2);
            // The axes ahead and to the left lie in the floor.
            const Pose3 T = on_floor(pose, below);
            for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1e-4, 0, 0), Eigen::Vector3d(0, 1e-4, 0)}) {
                const Eigen::Vector3d p = T * axis;
                ASSERT_NEAR(p.z(), floor.height_m(p.head<2>()), 1e-9);
            }
        }
    }
    EXPECT_NEAR(std::sqrt(sum2_pitch / samples), sigma_rad, 0.1 * sigma_rad);
    EXPECT_NEAR(std::sqrt(sum2_roll / samples), sigma_rad, 0.1 * sigma_rad);
}

TEST(UnevenFloor, leaves_the_planar_path_and_is_the_same_where_the_cart_comes_back_to) {
    const auto level = scene_of(test_scenario("cart_floor.ini"), {"world.sigma_tilt_deg=0"});
    const auto uneven = scene_of(test_scenario("cart_floor.ini"));
    const TrueMotion &a = level->drive.motion, &b = uneven->drive.motion;
    double steepest_rad = 0;
    for (StampNs t = 0; t < a.duration_ns(); t += 333'000'000) {
        ASSERT_EQ(a.planar_pose_at(t).x_m, b.planar_pose_at(t).x_m);
        const Pose3 pose = b.pose_at(t);
        ASSERT_EQ(a.pose_at(t).translation_m.z(), 0);
        ASSERT_EQ(pose.translation_m.x(), a.pose_at(t).translation_m.x());
        ASSERT_NEAR(wrap_to_pi(pose.yaw_rad() - b.planar_pose_at(t).phi_rad), 0, 1e-9);
        steepest_rad = std::max(steepest_rad, std::acos((pose.rotation * Eigen::Vector3d::UnitZ()).z()));
    }
    EXPECT_GT(steepest_rad, 0.2 * M_PI / 180);
    EXPECT_LT(steepest_rad, 1.5 * M_PI / 180);
    EXPECT_NEAR(b.pose_at(b.duration_ns()).translation_m.z(), b.pose_at(0).translation_m.z(), 2e-3);
}

TEST(Clutter, keeps_clear_of_the_route_of_walls_and_of_itself) {
    const Waypoints route{{-10, 0}, {10, 0}};
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        World world;
        add_box(world, {3, 3}, 0.5, 0.5, 0, 2.8);
        const std::size_t drawn = world.walls.size();
        add_clutter(world, {{-8, -5, 8, 5, 20}}, route, 0.8, seed);
        ASSERT_EQ(world.walls.size(), drawn + 20 * 4) << "there is room for all";
        for (std::size_t i = drawn; i < world.walls.size(); ++i) {
            const Wall& wall = world.walls[i];
            EXPECT_GE(std::min(std::abs(wall.from_m.y()), std::abs(wall.to_m.y())), 0.8 - 1e-9);
            EXPECT_GT(wall.from_m.y() * wall.to_m.y(), 0);
            EXPECT_LE(wall.from_m.cwiseAbs().x(), 8);
            EXPECT_LE(wall.from_m.cwiseAbs().y(), 5);
        }
    }
}

/// A scenario of carts, and places that its cart comes back to.
struct CartWorld {
    const char* name;
    int passes_of_start;  ///< after it has set off
    double least_length_m, most_length_m;
};

class CartWorlds : public ::testing::TestWithParam<CartWorld> {};

TEST_P(CartWorlds, keep_the_cart_clear_of_everything) {
    EXPECT_GT(clearance_m(*scene_of(dataset(GetParam().name))), 0.3);
}

TEST_P(CartWorlds, lead_through_the_start_again_and_end_there) {
    const auto scene = scene_of(dataset(GetParam().name));
    double length_m = 0, away_m = 0;
    int passes = 0;
    Eigen::Vector2d last_m = Eigen::Vector2d::Zero();
    for (StampNs t = 0; t <= scene->duration_ns(); t += 100'000'000) {
        const Pose2 T_map_base = scene->drive.motion.planar_pose_at(t);
        length_m += (T_map_base.translation() - last_m).norm();
        last_m = T_map_base.translation();
        away_m = std::max(away_m, last_m.norm());
        if (away_m > 5 && last_m.norm() < 0.5) {
            ++passes;
            away_m = 0;
            EXPECT_LT(std::abs(wrap_to_pi(T_map_base.phi_rad)), 15 * M_PI / 180) << "the same way round";
        }
    }
    EXPECT_EQ(passes, GetParam().passes_of_start);
    EXPECT_LT(last_m.norm(), 0.2);
    EXPECT_GT(length_m, GetParam().least_length_m);
    EXPECT_LT(length_m, GetParam().most_length_m);
    EXPECT_LT((scene->drive.motion.planar_pose_at(9'000'000'000).translation()).norm(), 1e-12)
        << "time to align an IMU";
}

INSTANTIATE_TEST_SUITE_P(Datasets, CartWorlds,
                         ::testing::Values(CartWorld{"cart_loops.ini", 3, 600, 640},
                                           CartWorld{"cart_corridor.ini", 3, 300, 325},
                                           CartWorld{"cart_twin_rooms.ini", 2, 320, 365}),
                         [](const auto& test) {
                             const std::string name = test.param.name;
                             return name.substr(0, name.size() - 4);
                         });

TEST(CartFurniture, furniture_differs_from_seed_to_seed) {
    const auto a = scene_of(dataset("cart_loops.ini"), seed_is(1));
    const auto b = scene_of(dataset("cart_loops.ini"), seed_is(2));
    bool differ = a->world.walls.size() != b->world.walls.size();
    for (std::size_t i = 0; !differ && i < a->world.walls.size(); ++i)
        differ = a->world.walls[i].from_m != b->world.walls[i].from_m;
    EXPECT_TRUE(differ);
}

TEST(CartFurniture, twin_rooms_look_the_same) {
    const auto scene = scene_of(dataset("cart_twin_rooms.ini"));
    for (const Eigen::Vector2d& place_m :
         {Eigen::Vector2d(1, -15.6), {-1, -15.6}, {-3, -15.6}, {-3, -13}, {1, -13}}) {
        for (int k = 0; k < 360; ++k) {
            const auto range_m = [&](double offset_m) {
                return scene->caster
                    ->cast({place_m.x() + offset_m, place_m.y(), 0.45},
                           {std::cos(k * 0.01745), std::sin(k * 0.01745), 0}, 30)
                    .range_m;
            };
            ASSERT_NEAR(range_m(0), range_m(-16), 1e-6) << place_m.transpose() << ", beam " << k;
        }
    }
}
