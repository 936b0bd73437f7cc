/// Vehicle, driver and encoders: exact without slip, and as random as asked for with it.
#include <gtest/gtest.h>

#include <cmath>

#include "simulation/drive.h"
#include "simulation/encoders.h"

using namespace loopline;
using namespace loopline::simulation;

namespace {

VehicleSettings perfect() {
    VehicleSettings v;
    v.wander = v.slip_straight = v.slip_turn_outer = v.slip_turn_inner = v.sigma_slip_turn = 0;
    v.sigma_straight_m = v.sigma_turn_m = v.sigma_side_m = v.bumps_hz = 0;
    return v;
}

const Waypoints round{{0, 0}, {3, 0}, {3, 2}, {0, 2}, {0, 0}, {1, 0}};

Drive drive(const VehicleSettings& vehicle, std::uint64_t seed = 1) {
    auto driven = drive_route(round, {}, {}, vehicle, seed);
    if (!driven) throw std::runtime_error("it does not arrive");
    return std::move(*driven);
}

double heading_turned_rad(const VehicleSettings& settings, Regime regime, std::uint64_t seed,
                          double duration_s) {
    Vehicle vehicle(settings, 0.005, RandomStream(seed, "vehicle"));
    double turned_rad = 0;
    for (int i = 0; i < duration_s / 0.005; ++i) turned_rad += vehicle.step(regime).motion.turn_rad;
    return turned_rad;
}

}  // namespace

TEST(SimulatedDrive, without_slip_dead_reckoning_is_the_truth) {
    const Drive driven = drive(perfect());
    EncoderSettings settings;
    settings.metres_per_tick_m = 0;
    settings.track_width_m = perfect().track_width_m;
    Encoders encoders(settings, driven);
    for (StampNs t = 0; t <= driven.motion.duration_ns(); t += 49'999'900) {
        const Pose2 reckoned = encoders.read(t).T_odom_base, truth = driven.motion.planar_pose_at(t);
        ASSERT_NEAR(reckoned.x_m, truth.x_m, 1e-9);
        ASSERT_NEAR(reckoned.y_m, truth.y_m, 1e-9);
        ASSERT_NEAR(wrap_to_pi(reckoned.phi_rad - truth.phi_rad), 0, 1e-9);
    }
    // With encoder steps it stays within what a step means for the heading.
    settings.metres_per_tick_m = 1e-4;
    Encoders stepped(settings, driven);
    const Pose2 reckoned = stepped.read(driven.motion.duration_ns()).T_odom_base;
    EXPECT_LT((reckoned.translation() - driven.motion.last().translation()).norm(), 0.005);
    EXPECT_LT(std::abs(wrap_to_pi(reckoned.phi_rad - driven.motion.last().phi_rad)),
              1e-4 / settings.track_width_m + 1e-9);
}

TEST(SimulatedDrive, ticks_and_velocity_are_those_of_the_rims) {
    const Drive driven = drive(perfect());
    EncoderSettings settings;
    settings.track_width_m = perfect().track_width_m;
    Encoders encoders(settings, driven);
    encoders.read(4'000'000'000);
    const EncoderReading reading = encoders.read(6'000'000'000);
    EXPECT_NEAR(static_cast<double>(reading.left_ticks) * 1e-4, driven.rim_at(6'000'000'000).left, 1e-4);
    EXPECT_NEAR(reading.velocity.forward_m, 0.1023, 1e-4);
    EXPECT_NEAR(reading.velocity.turn_rad, 0, 1e-3);
}

TEST(SimulatedDrive, keeps_to_its_route_and_tells_its_commands) {
    const Drive driven = drive(VehicleSettings{});
    int corners = 0;
    for (const Command& command : driven.commands) corners += command.regime == Regime::left;
    EXPECT_GE(corners, 4);
    EXPECT_EQ(driven.commands.front().time_ns, 0);
    EXPECT_EQ(driven.commands.front().regime, Regime::straight);
    EXPECT_NEAR(driven.motion.last().x_m, 1, 0.05);
    for (StampNs t = 0; t < driven.motion.duration_ns(); t += 100'000'000) {
        const Eigen::Vector2d p = driven.motion.planar_pose_at(t).translation();
        const double off_m =
            std::min({std::abs(p.x()), std::abs(p.x() - 3), std::abs(p.y()), std::abs(p.y() - 2)});
        ASSERT_LT(off_m, 0.25);
    }
}

TEST(SimulatedDrive, a_seed_repeats_its_drive_and_another_does_not) {
    const Drive a = drive(VehicleSettings{}, 7), b = drive(VehicleSettings{}, 7),
                c = drive(VehicleSettings{}, 8);
    EXPECT_EQ(a.motion.duration_ns(), b.motion.duration_ns());
    EXPECT_EQ(a.motion.last().x_m, b.motion.last().x_m);
    EXPECT_EQ(a.motion.last().phi_rad, b.motion.last().phi_rad);
    EXPECT_NE(a.motion.last().phi_rad, c.motion.last().phi_rad);
}

TEST(SimulatedVehicle, random_ways_grow_as_a_random_walk) {
    VehicleSettings settings = perfect();
    settings.wheel_lag_s = 0;
    settings.sigma_straight_m = 0.01;
    constexpr int drives = 400;
    const double duration_s = 4 / settings.straight_mps;  // 4 m
    double sum2 = 0;
    for (int i = 0; i < drives; ++i)
        sum2 += std::pow(
            heading_turned_rad(settings, Regime::straight, static_cast<std::uint64_t>(i), duration_s), 2);
    // Two wheels, each with sigma sqrt(4 m).
    const double expected_rad = std::sqrt(2.0) * 0.01 * std::sqrt(4.0) / settings.track_width_m;
    EXPECT_NEAR(std::sqrt(sum2 / drives), expected_rad, 5 * expected_rad / std::sqrt(2.0 * drives));
}

TEST(SimulatedVehicle, slip_of_a_regime_acts_in_that_regime) {
    VehicleSettings settings = perfect();
    settings.wheel_lag_s = 0;
    const double commanded_rad = heading_turned_rad(settings, Regime::left, 1, 5);
    EXPECT_NEAR(commanded_rad, 5 * (0.0634 - 0.0106) / settings.track_width_m, 1e-9);
    settings.slip_turn_inner = 0.5;
    EXPECT_NEAR(heading_turned_rad(settings, Regime::left, 1, 5),
                5 * (0.0634 - 0.0053) / settings.track_width_m, 1e-9);
    EXPECT_NEAR(heading_turned_rad(settings, Regime::right, 1, 5),
                -5 * (0.0634 - 0.0053) / settings.track_width_m, 1e-9);
    EXPECT_NEAR(heading_turned_rad(settings, Regime::straight, 1, 5), 0, 1e-12);
    // Each turn draws its own slip.
    settings.sigma_slip_turn = 0.1;
    double sum = 0, sum2 = 0;
    constexpr int turns = 1000;
    for (int i = 0; i < turns; ++i) {
        const double turned_rad =
            heading_turned_rad(settings, Regime::left, static_cast<std::uint64_t>(i), 1);
        const double slip = 1 - (0.0634 - turned_rad * settings.track_width_m) / 0.0106;
        sum += slip;
        sum2 += slip * slip;
    }
    EXPECT_NEAR(sum / turns, 0.5, 5 * 0.1 / std::sqrt(turns));
    EXPECT_NEAR(std::sqrt(sum2 / turns - std::pow(sum / turns, 2)), 0.1, 5 * 0.1 / std::sqrt(2.0 * turns));
}
