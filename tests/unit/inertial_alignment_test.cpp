/// Initial alignment: the truth within its covariance, by Monte Carlo, and every reason for a refusal.
#include <gtest/gtest.h>

#include <random>

#include "inertial/alignment.h"
#include "inertial/rotation_vector.h"

using namespace loopline;
using namespace loopline::inertial;

namespace {

const Pose2 parked{3, -2, 0.7};

/// Readings at rest, on a floor that is not level.
struct Parked {
    Eigen::Quaterniond q_map_base = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX());
    Eigen::Vector3d gyro_bias_radps{0.01, -0.02, 0.03};
    Eigen::Vector3d accelerometer_bias_mps2 = Eigen::Vector3d::Zero();
    double gravity_mps2 = 9.80665, gyro_noise_radps = 0.005, accelerometer_noise_mps2 = 0.05;
    double duration_s = 3;
    std::mt19937_64 random{7};
    std::normal_distribution<double> normal;

    Eigen::Vector3d white(double sigma) {
        const double x = normal(random), y = normal(random), z = normal(random);
        return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
    }
    StandstillWindow window() {
        StandstillWindow readings(2);
        for (StampNs t = 0; t <= std::llround(duration_s * 1e9); t += 10'000'000)
            readings.add({t, gyro_bias_radps + white(gyro_noise_radps),
                          q_map_base.conjugate() * Eigen::Vector3d(0, 0, gravity_mps2) +
                              accelerometer_bias_mps2 + white(accelerometer_noise_mps2)});
        return readings;
    }
    Alignment result() { return align(window().mean(), parked, {}, {}); }
};

}  // namespace

TEST(InertialAlignment, finds_tilt_and_gyro_bias) {
    Parked vehicle;
    const auto alignment = vehicle.result();
    ASSERT_TRUE(alignment.aligned());
    EXPECT_LT(log_so3(vehicle.q_map_base * alignment.state.q_map_base.conjugate()).norm(), 2e-3);
    EXPECT_LT((alignment.state.gyro_bias_radps - vehicle.gyro_bias_radps).norm(), 2e-3);
    EXPECT_EQ(alignment.state.stamp_ns, 3'000'000'000);
    EXPECT_EQ(alignment.state.p_map_m, Eigen::Vector3d(3, -2, 0));
    EXPECT_NEAR(alignment.gravity_mps2, 9.80665, 0.02);
}

TEST(InertialAlignment, its_covariance_is_the_spread_of_its_errors) {
    constexpr int starts = 2000;
    Parked vehicle;
    vehicle.duration_s = 2;
    Eigen::Matrix<double, 9, 9> sampled = Eigen::Matrix<double, 9, 9>::Zero(), claimed = sampled;
    for (int i = 0; i < starts; ++i) {
        vehicle.accelerometer_bias_mps2 = vehicle.white(0.05);
        const auto alignment = vehicle.result();
        NavigationState truth = alignment.state;
        truth.q_map_base = vehicle.q_map_base;
        truth.gyro_bias_radps = vehicle.gyro_bias_radps;
        truth.accelerometer_bias_mps2 = vehicle.accelerometer_bias_mps2;
        const Eigen::Matrix<double, 9, 1> e = error_between(alignment.state, truth).tail<9>();
        sampled += e * e.transpose() / starts;
        claimed = alignment.covariance.bottomRightCorner<9, 9>();
    }
    for (int i = 0; i < 9; ++i) {
        if (i == 2) continue;  // the heading is given
        EXPECT_NEAR(sampled(i, i) / claimed(i, i), 1, 0.15) << i;
        for (int j = 0; j < i; ++j) {
            if (j == 2) continue;
            EXPECT_NEAR(sampled(i, j) / std::sqrt(claimed(i, i) * claimed(j, j)),
                        claimed(i, j) / std::sqrt(claimed(i, i) * claimed(j, j)), 0.1)
                << i << ", " << j;
        }
    }
}

TEST(InertialAlignment, says_why_not) {
    Parked brief, shaking, turning, in_g;
    brief.duration_s = 1;
    EXPECT_TRUE(stands_still(Parked().window().mean(), {}));
    EXPECT_EQ(brief.result().status, AlignmentStatus::too_short);
    shaking.accelerometer_noise_mps2 = 0.6;
    EXPECT_FALSE(stands_still(shaking.window().mean(), {}));
    EXPECT_EQ(shaking.result().status, AlignmentStatus::moving);
    turning.gyro_bias_radps.z() = 0.3;
    EXPECT_EQ(turning.result().status, AlignmentStatus::turning);
    in_g.gravity_mps2 = 1;
    EXPECT_EQ(in_g.result().status, AlignmentStatus::wrong_gravity);
    EXPECT_NE(words(AlignmentStatus::wrong_gravity).find("unit"), std::string::npos);
    EXPECT_EQ(align(StandstillWindow(2).mean(), parked, {}, {}).status, AlignmentStatus::too_short);
}

TEST(InertialAlignment, a_stamp_that_goes_back_starts_the_window_anew) {
    Parked vehicle;
    auto window = vehicle.window();
    EXPECT_GT(window.mean().duration_s, 1.9);
    window.add({0, {}, {}});
    EXPECT_EQ(window.mean().count, 1u);
}
