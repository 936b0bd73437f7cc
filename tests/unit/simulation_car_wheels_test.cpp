/// Wheels of cars: slip in bends, ways uphill, scale errors.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>

#include "simulation/pushed_drive.h"
#include "support/simulated_scene.h"

using namespace loopline;
using namespace loopline::simulation;
using namespace loopline::test;

TEST(CarWheels, the_inner_wheel_slips_in_bends_by_the_acceleration_to_its_side) {
    // A full circle to the left of radius 20 m at 5 m/s: 1.25 m/s^2.
    VehicleSettings vehicle;
    vehicle.track_width_m = 1.5;
    vehicle.slip_straight = vehicle.sigma_straight_m = 0;
    Drive drive;
    drive.motion = TrueMotion({}, 5'000'000);
    const int steps = static_cast<int>(2 * M_PI * 20 / 5 / 0.005);
    for (int i = 0; i < steps; ++i) drive.motion.append({0.025, 0, 0.025 / 20});
    roll_wheels(drive, vehicle, 0.004, 1);
    const double way_m = 0.025 * steps, turn_rad = way_m / 20;
    EXPECT_NEAR(drive.rim_m.back().left, (way_m - turn_rad * 0.75) / (1 - 0.004 * 1.25), 1e-9);
    EXPECT_NEAR(drive.rim_m.back().right, way_m + turn_rad * 0.75, 1e-9);
    Encoders encoders({0, 1.5, 1, 1}, drive);
    const double reckoned_rad = (drive.rim_m.back().right - drive.rim_m.back().left) / 1.5;
    EXPECT_LT(reckoned_rad, turn_rad) << "encoders see less of the turn";
    EXPECT_NEAR(wrap_to_pi(encoders.read(drive.motion.duration_ns()).T_odom_base.phi_rad - reckoned_rad), 0,
                1e-9);
}

TEST(CarWheels, a_way_uphill_is_as_long_as_the_ground) {
    const auto scene = scene_of(dataset("ramp_gallery.ini"),
                                {"vehicle.slip_straight=0", "vehicle.sigma_straight_m=0", "cart.slip_turn=0",
                                 "town.ground_cell_m=50", "town.trees_per_km=0", "town.bushes_per_km=0"});
    const TrueMotion& motion = scene->drive.motion;
    double way_m = 0, plan_m = 0;
    for (StampNs t = 0; t < motion.duration_ns(); t += 50'000'000) {
        const Eigen::Vector3d step_m =
            motion.pose_at(t + 50'000'000).translation_m - motion.pose_at(t).translation_m;
        way_m += step_m.norm();
        plan_m += step_m.head<2>().norm();
    }
    const WheelPair rim_m = scene->drive.rim_m.back();
    EXPECT_GT(way_m - plan_m, 1);
    EXPECT_NEAR((rim_m.left + rim_m.right) / 2, way_m, 0.05);
}

TEST(CarWheels, scale_errors_that_both_wheels_share_turn_nothing) {
    double worst_turn_rad = 0, squares = 0;
    constexpr int seeds = 40;
    for (int seed = 1; seed <= seeds; ++seed) {
        WorldSimulator simulator;
        load_scenario(test_scenario("cart_floor.ini"),
                      {"simulation.sensors=wheels", "wheels.sigma_scale=0", "wheels.sigma_common_scale=0.02",
                       "wheels.scale_left=1", "wheels.scale_right=1", "wheels.metres_per_tick_m=0"},
                      simulator);
        Scene scene;
        scene.seed = static_cast<std::uint64_t>(seed);
        scene.vehicle.track_width_m = 1.5;
        scene.drive.motion = TrueMotion({}, 5'000'000);
        for (int i = 0; i < 400; ++i) {
            scene.drive.motion.append({0.025, 0, 0});
            scene.drive.rim_m.push_back({0.025 * (i + 1), 0.025 * (i + 1)});
        }
        Sensor* const wheels = simulator.sensors_in_use().front();
        wheels->start(scene);
        Pose2 last;
        while (wheels->next_time_ns() <= scene.duration_ns()) {
            const auto o = std::dynamic_pointer_cast<mrpt::obs::CObservationOdometry>(wheels->next());
            last = {o->odometry.x(), o->odometry.y(), o->odometry.phi()};
            EXPECT_FALSE(o->hasEncodersInfo);
        }
        worst_turn_rad = std::max(worst_turn_rad, std::abs(last.phi_rad));
        squares += std::pow(last.x_m / 10 - 1, 2) / seeds;
    }
    EXPECT_LT(worst_turn_rad, 1e-12);
    EXPECT_NEAR(std::sqrt(squares), 0.02, 5 * 0.02 / std::sqrt(2.0 * seeds));
}
