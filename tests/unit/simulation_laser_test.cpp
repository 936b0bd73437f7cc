/// The laser's model against its statistics, and its true motion during a sweep.
#include <gtest/gtest.h>

#include <cmath>

#include "simulation/floor_plan.h"
#include "simulation/laser.h"
#include "simulation/servo.h"

using namespace loopline;
using namespace loopline::simulation;

namespace {

LaserSettings exact() {
    LaserSettings settings;
    settings.sigma_range_m = settings.resolution_m = settings.dropouts = 0;
    settings.beam_width_rad = settings.mixed_pixels = 0;
    return settings;
}

Pose3 standing(StampNs) {
    return Pose3({0, 0, 0.5}, Eigen::Quaterniond::Identity());
}

World room(double half_m) {
    World world;
    add_box(world, {0, 0}, 2 * half_m, 2 * half_m, 0, 3);
    return world;
}

}  // namespace

TEST(SimulatedLaser, noise_quantisation_and_dropouts_have_the_statistics_asked_for) {
    World circle;
    constexpr int sides = 3600;
    for (int i = 0; i < sides; ++i) {
        const double a = 2 * M_PI * i / sides, b = 2 * M_PI * (i + 1) / sides;
        circle.walls.push_back(
            {{5 * std::cos(a), 5 * std::sin(a)}, {5 * std::cos(b), 5 * std::sin(b)}, 0, 3});
    }
    const RayCaster caster(circle);
    LaserSettings settings = exact();
    settings.sigma_range_m = 0.02;
    settings.dropouts = 0.1;
    Laser laser(settings, RandomStream(3, "laser"));
    double sum = 0, sum2 = 0;
    int valid = 0, beams = 0;
    for (int k = 0; k < 500; ++k)
        for (const Beam& beam : laser.scan(k, standing, caster)) {
            ++beams;
            if (!beam.valid) {
                EXPECT_EQ(beam.range_m, 0);
                continue;
            }
            ++valid;
            sum += beam.range_m - 5;
            sum2 += std::pow(beam.range_m - 5, 2);
        }
    const double n = valid, mean_m = sum / n, sigma_m = std::sqrt(sum2 / n - mean_m * mean_m);
    // Five standard deviations of each estimate.
    EXPECT_NEAR(mean_m, 0, 5 * 0.02 / std::sqrt(n));
    EXPECT_NEAR(sigma_m, 0.02, 5 * 0.02 / std::sqrt(2 * n));
    EXPECT_NEAR(1 - n / beams, 0.1, 5 * std::sqrt(0.1 * 0.9 / beams));

    settings.resolution_m = 0.05;
    Laser coarse(settings, RandomStream(3, "laser"));
    for (const Beam& beam : coarse.scan(0, standing, caster))
        EXPECT_NEAR(std::remainder(beam.range_m, 0.05), 0, 1e-12);
}

TEST(SimulatedLaser, range_limits) {
    const World world = room(4);
    const RayCaster caster(world);
    LaserSettings settings = exact();
    settings.max_range_m = 4.5;
    Laser laser(settings, RandomStream(1, "laser"));
    const auto& beams = laser.scan(0, standing, caster);
    EXPECT_TRUE(beams[90].valid);
    EXPECT_NEAR(beams[90].range_m, 4, 1e-12);
    EXPECT_FALSE(beams[45].valid) << "the corner is 5.7 m away";
    EXPECT_EQ(beams[45].range_m, 4.5);
}

TEST(SimulatedLaser, every_beam_is_measured_from_the_pose_of_its_own_time) {
    const World world = room(6);
    const RayCaster caster(world);
    LaserSettings settings = exact();
    settings.rate_hz = 10;
    settings.sweep_part = 1;
    const auto moving = [](StampNs t) {
        const double s = static_cast<double>(t) * 1e-9;
        return Pose3(Pose2{2 * s - 0.3, 0.5 * s, 3 * s}) *
               Pose3({0.1, 0, 0.5}, Eigen::Quaterniond::Identity());
    };
    Laser laser(settings, RandomStream(1, "laser"));
    const StampNs start_ns = 40'000'000;
    const auto& beams = laser.scan(start_ns, moving, caster);
    double rigid_error_m = 0;
    for (int k = 0; k < settings.beams; ++k) {
        const double a = laser.angle_rad(k), r = beams[static_cast<std::size_t>(k)].range_m;
        const Eigen::Vector3d p_sensor(r * std::cos(a), r * std::sin(a), 0);
        const auto off_wall_m = [](const Eigen::Vector3d& p) {
            return std::abs(p.head<2>().cwiseAbs().maxCoeff() - 6);
        };
        EXPECT_NEAR(off_wall_m(moving(start_ns + laser.beam_time_ns(k)) * p_sensor), 0, 1e-9);
        rigid_error_m = std::max(rigid_error_m, off_wall_m(moving(start_ns) * p_sensor));
    }
    EXPECT_GT(rigid_error_m, 0.1) << "so much it would be without";
    EXPECT_EQ(laser.beam_time_ns(0), 0);
    EXPECT_EQ(laser.beam_time_ns(180), 100'000'000);
}

TEST(SimulatedLaser, people_move_during_the_sweep) {
    const RayCaster nothing(World{});
    LaserSettings settings = exact();
    settings.rate_hz = 10;
    settings.sweep_part = 1;
    Laser laser(settings, RandomStream(1, "laser"));
    const auto walking = [](StampNs t) {
        return std::vector<Cylinder>{{{2, 10 * seconds_between(0, t) - 0.5}, 0.3, 1.7}};
    };
    const auto& beams = laser.scan(0, standing, nothing, walking);
    int seen = 0;
    for (int k = 0; k < settings.beams; ++k) {
        const Beam& beam = beams[static_cast<std::size_t>(k)];
        if (!beam.valid) continue;
        ++seen;
        const double a = laser.angle_rad(k);
        const Eigen::Vector2d p(beam.range_m * std::cos(a), beam.range_m * std::sin(a));
        EXPECT_NEAR((p - walking(laser.beam_time_ns(k))[0].centre_m).norm(), 0.3, 1e-9);
    }
    EXPECT_GT(seen, 10);
}

TEST(SimulatedLaser, mixed_pixels_lie_between_the_two_surfaces_of_an_edge_and_nowhere_else) {
    World world;
    world.walls.push_back({{3, 0.513}, {3, 10}, 0, 3});  // a near wall that ends in front of
    world.walls.push_back({{4, -10}, {4, 10}, 0, 3});    // a far one
    const RayCaster caster(world);
    LaserSettings settings = exact();
    settings.beams = 361;
    settings.beam_width_rad = 0.5 * M_PI / 180;
    settings.mixed_pixels = 0.5;
    Laser laser(settings, RandomStream(5, "laser"));
    int mixed = 0;
    for (int k = 0; k < 400; ++k) {
        const auto& beams = laser.scan(k, standing, caster);
        for (int i = 0; i < settings.beams; ++i) {
            const Beam& beam = beams[static_cast<std::size_t>(i)];
            if (!beam.valid) continue;
            const double a = laser.angle_rad(i), x = beam.range_m * std::cos(a);
            if (std::abs(x - 3) < 1e-9 || std::abs(x - 4) < 1e-9) continue;
            ++mixed;
            EXPECT_NEAR(a, std::atan2(0.513, 3), settings.beam_width_rad / 2) << "only at the edge";
            EXPECT_GT(x, 3 - 0.02);
            EXPECT_LT(x, 4 + 0.02);
        }
    }
    EXPECT_NEAR(mixed, 200, 60);
    // A wide gap is told apart: the nearer surface counts.
    settings.mixed_gap_m = 0.5;
    Laser narrow(settings, RandomStream(5, "laser"));
    for (int k = 0; k < 50; ++k) {
        const auto& beams = narrow.scan(k, standing, caster);
        for (int i = 0; i < settings.beams; ++i) {
            const Beam& beam = beams[static_cast<std::size_t>(i)];
            const double x = beam.range_m * std::cos(narrow.angle_rad(i));
            ASSERT_TRUE(!beam.valid || std::min(std::abs(x - 3), std::abs(x - 4)) < 0.02);
        }
    }
}

TEST(SimulatedServo, goes_up_and_down_between_its_ends) {
    const ServoSettings servo{-0.5, 1.0, 10};
    const auto at_s = [&](double s) { return servo_elevation_rad(servo, static_cast<StampNs>(s * 1e9)); };
    EXPECT_NEAR(at_s(0), -0.5, 1e-12);
    EXPECT_NEAR(at_s(5), 0.25, 1e-12);
    EXPECT_NEAR(at_s(10), 1, 1e-12);
    EXPECT_NEAR(at_s(15), 0.25, 1e-12);
    EXPECT_NEAR(at_s(40), -0.5, 1e-9);
    const Eigen::Vector3d ahead = T_mount_servo(0.3) * Eigen::Vector3d(1, 0, 0);
    EXPECT_NEAR(ahead.z(), std::sin(0.3), 1e-12) << "a positive elevation looks up";
}
