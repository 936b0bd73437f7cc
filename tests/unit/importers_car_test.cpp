/// Motion of a car by its wheels, against circles in closed form and a fine integration.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "importers/car_odometry.h"

using namespace loopline;

namespace {

constexpr double wheel_base_m = 2.83, left_m = 0.76;  // Victoria Park's car

}  // namespace

TEST(CarOdometry, a_wheel_beside_the_middle_runs_on_a_circle_of_its_own) {
    for (const double radius_m : {-40.0, -6.0, 4.0, 25.0, 300.0})
        for (const double wheel_left_m : {-0.7, 0.0, left_m}) {
            const double turn_radps = 2 / radius_m;  // the middle runs at 2 m/s
            const double wheel_mps = turn_radps * (radius_m - wheel_left_m);
            const double steering_rad = std::atan(wheel_base_m / radius_m);
            const CarVelocity velocity =
                velocity_by_steering({wheel_base_m, wheel_left_m}, wheel_mps, steering_rad);
            EXPECT_NEAR(velocity.forward_mps, 2, 1e-12) << radius_m << " " << wheel_left_m;
            EXPECT_NEAR(velocity.turn_radps, turn_radps, 1e-12);
            EXPECT_EQ(velocity.left_mps, 0);
        }
}

TEST(CarOdometry, two_wheels_on_circles_about_one_point_tell_the_middle) {
    const double radius_m = 12, width_m = 1.57, turn_radps = -0.4;
    const CarVelocity velocity = velocity_by_wheels(width_m, turn_radps * (radius_m - width_m / 2),
                                                    turn_radps * (radius_m + width_m / 2));
    EXPECT_NEAR(velocity.forward_mps, turn_radps * radius_m, 1e-12) << "backwards";
    EXPECT_NEAR(velocity.turn_radps, turn_radps, 1e-12);
}

TEST(CarOdometry, a_circle_is_exact_whatever_the_times_of_the_lines) {
    const double radius_m = 9, steering_rad = std::atan(wheel_base_m / radius_m);
    const double turn_radps = 0.5, wheel_mps = turn_radps * (radius_m - left_m);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> step_s(0.001, 0.7);
    CarPath path;
    const StampNs start_ns = 1'500'000'000'000'000'000;
    StampNs stamp_ns = start_ns;
    for (int i = 0; i < 500; ++i) {
        path.add(stamp_ns, velocity_by_steering({wheel_base_m, left_m}, wheel_mps, steering_rad));
        const double angle_rad = turn_radps * seconds_between(start_ns, stamp_ns);
        const Pose2& pose = path.T_odom_base();
        ASSERT_NEAR(pose.x_m, radius_m * std::sin(angle_rad), 1e-9);
        ASSERT_NEAR(pose.y_m, radius_m * (1 - std::cos(angle_rad)), 1e-9);
        ASSERT_NEAR(wrap_to_pi(pose.phi_rad - angle_rad), 0, 1e-9);
        stamp_ns += static_cast<StampNs>(step_s(random) * 1e9);
    }
}

TEST(CarOdometry, a_bend_that_tightens_is_followed_to_the_second_order_of_the_step) {
    const auto turn_radps = [](double t_s) { return 0.3 * std::sin(0.8 * t_s); };
    const auto error_m = [&](int rate_hz) {
        CarPath path;
        for (int i = 0; i <= 10 * rate_hz; ++i) {
            const double t_s = static_cast<double>(i) / rate_hz;
            path.add(static_cast<StampNs>(std::llround(t_s * 1e9)), {5 + t_s, 0, turn_radps(t_s)});
        }
        double x_m = 0, y_m = 0;  // by the heading in closed form, in steps of 0.1 ms
        for (int i = 0; i < 100'000; ++i) {
            const double t_s = (i + 0.5) * 1e-4, heading_rad = 0.375 * (1 - std::cos(0.8 * t_s));
            x_m += (5 + t_s) * std::cos(heading_rad) * 1e-4;
            y_m += (5 + t_s) * std::sin(heading_rad) * 1e-4;
        }
        return std::hypot(path.T_odom_base().x_m - x_m, path.T_odom_base().y_m - y_m);
    };
    const double coarse_m = error_m(10), fine_m = error_m(40);
    EXPECT_LT(coarse_m, 0.02);
    EXPECT_NEAR(coarse_m / fine_m, 16, 2);
}

TEST(CarOdometry, times_that_repeat_or_go_back_move_nothing) {
    CarPath path;
    path.add(1'000'000'000, {1, 0, 0});
    path.add(2'000'000'000, {1, 0, 0});
    path.add(2'000'000'000, {1, 0, 0});
    path.add(1'500'000'000, {1, 0, 0});
    EXPECT_EQ(path.T_odom_base().x_m, 1);
    path.add(3'000'000'000, {1, 0, 0});
    EXPECT_EQ(path.T_odom_base().x_m, 2);
}
