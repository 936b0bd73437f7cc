/// Interpolation on SE(3), and poses of a trajectory between its entries.
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <unsupported/Eigen/MatrixFunctions>

#include "api/path_sampler.h"
#include "api/pose3_motion.h"

using namespace loopline;

namespace {

Pose3 random_pose(std::mt19937_64& random, double turn_rad) {
    std::normal_distribution<double> n(0, 1);
    const Eigen::Vector3d axis = Eigen::Vector3d(n(random), n(random), n(random)).normalized();
    return {{5 * n(random), 5 * n(random), 5 * n(random)},
            Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, axis))};
}

void expect_equal(const Pose3& a, const Pose3& b, double tolerance) {
    EXPECT_LT((a.translation_m - b.translation_m).norm(), tolerance);
    EXPECT_LT(a.rotation.angularDistance(b.rotation), tolerance);
}

Trajectory three_poses() {
    Trajectory path;
    for (int i = 0; i < 3; ++i)
        path.append(10 * static_cast<std::uint64_t>(i), 1'000'000'000LL * i, Pose3(Pose2{double(i), 0, 0}),
                    Matrix6d::Zero());
    return path;
}

}  // namespace

TEST(Pose3Motion, logarithm_undoes_the_exponential_for_small_and_large_turns) {
    std::mt19937_64 random(1);
    for (const double turn_rad : {0.0, 1e-9, 1e-5, 0.01, 0.0999, 0.1001, 1.0, 3.0, 3.1415})
        for (int i = 0; i < 20; ++i) {
            const Pose3 pose = random_pose(random, turn_rad);
            const Twist3 twist = log_se3(pose);
            EXPECT_NEAR(twist.turn_rad.norm(), turn_rad, 1e-9);
            expect_equal(exp_se3(twist), pose, 1e-10);
        }
}

TEST(Pose3Motion, exponential_is_that_of_the_4_by_4_matrix) {
    std::mt19937_64 random(2);
    std::normal_distribution<double> n(0, 1);
    for (int i = 0; i < 200; ++i) {
        const Twist3 twist{{n(random), n(random), n(random)}, {n(random), n(random), n(random)}};
        const auto& w = twist.turn_rad;
        Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
        generator.topLeftCorner<3, 3>() << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
        generator.topRightCorner<3, 1>() = twist.shift_m;
        const Eigen::Matrix4d expected = generator.exp();
        const Pose3 pose = exp_se3(twist);
        EXPECT_LT((pose.translation_m - expected.topRightCorner<3, 1>()).norm(), 1e-12);
        EXPECT_LT((pose.rotation.toRotationMatrix() - expected.topLeftCorner<3, 3>()).norm(), 1e-12);
    }
}

TEST(Pose3Motion, interpolation_follows_the_arc_of_a_turning_vehicle) {
    // A quarter of a circle with radius 2 m about (0, 2).
    const Pose3 T_map_a(Pose2{0, 0, 0}), T_map_b(Pose2{2, 2, M_PI / 2});
    for (const double u : {-0.5, 0.0, 0.25, 0.5, 0.9, 1.0, 1.5}) {
        const double turn_rad = u * M_PI / 2;
        const Pose3 expected(Pose2{2 * std::sin(turn_rad), 2 - 2 * std::cos(turn_rad), turn_rad});
        expect_equal(interpolate_se3(T_map_a, T_map_b, u), expected, 1e-12);
    }
}

TEST(Pose3Motion, a_segment_between_equal_times_stands_still) {
    const Pose3 pose(Pose2{1, 2, 3});
    expect_equal(ScrewSegment(5, pose, 5, Pose3(Pose2{9, 9, 9})).at(1'000'000'000), pose, 1e-15);
}

TEST(PathSampler, interpolates_at_constant_twist_and_has_no_pose_outside) {
    const Trajectory path = three_poses();
    PathSampler sampler(path, 2);
    EXPECT_NEAR(sampler.at(250'000'000, 5)->translation_m.x(), 0.25, 1e-12);
    EXPECT_NEAR(sampler.at(1'900'000'000, 5)->translation_m.x(), 1.9, 1e-12);
    EXPECT_NEAR(sampler.at(0, 0)->translation_m.x(), 0, 1e-12);
    EXPECT_NEAR(sampler.at(2'000'000'000, 20)->translation_m.x(), 2, 1e-12);
    EXPECT_FALSE(sampler.at(-1, 0));
    EXPECT_FALSE(sampler.at(2'000'000'001, 20));
    EXPECT_FALSE(PathSampler(Trajectory(), 1).at(0, 0));
}

TEST(PathSampler, a_gap_and_a_damaged_pose_have_no_pose) {
    Trajectory path = three_poses();
    EXPECT_FALSE(PathSampler(path, 0.5).at(1'500'000'000, 10));
    path.revise(2, Pose3({std::numeric_limits<double>::quiet_NaN(), 0, 0}, Eigen::Quaterniond::Identity()),
                Matrix6d::Zero());
    PathSampler sampler(path, 2);
    EXPECT_TRUE(sampler.at(500'000'000, 0));
    EXPECT_FALSE(sampler.at(1'500'000'000, 10));
    EXPECT_TRUE(sampler.at(500'000'000, 0));
}

TEST(PathSampler, where_stamps_repeat_the_place_in_the_log_decides) {
    Trajectory path;  // the clock is set back by 2 s in the middle
    for (int i = 0; i < 6; ++i)
        path.append(static_cast<std::uint64_t>(i), 1'000'000'000LL * (i % 3), Pose3(Pose2{double(i), 0, 0}),
                    Matrix6d::Zero());
    PathSampler sampler(path, 2);
    EXPECT_NEAR(sampler.at(500'000'000, 1)->translation_m.x(), 0.5, 1e-12);
    EXPECT_NEAR(sampler.at(500'000'000, 4)->translation_m.x(), 3.5, 1e-12);
}
