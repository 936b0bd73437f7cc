/// A loop gone through both ways: the way back, and what both ways say together.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

#include "grid_slam/fusion_of_passes.h"
#include "grid_slam/pose_graph.h"
#include "grid_slam/wheel_navigation.h"

using namespace loopline;
using namespace loopline::grid_slam;

namespace {

Motion step_of_loop(std::size_t k, double heading_error_rad) {
    Motion step;
    step.T_before_now = {0.5, 0.02, 2 * M_PI / 24 + heading_error_rad};
    const double more = 1 + 0.5 * static_cast<double>(k % 3);
    step.covariance = more * Eigen::Vector3d(1e-4, 4e-5, 9e-6).asDiagonal().toDenseMatrix();
    return step;
}

TEST(Motion, way_back_has_the_covariance_of_samples) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    Motion there{{0.8, -0.3, 0.7}, Eigen::Matrix3d::Zero()};
    there.covariance << 4e-4, 1e-4, 5e-5, 1e-4, 2e-4, -3e-5, 5e-5, -3e-5, 1e-4;
    const Eigen::Matrix3d root = there.covariance.llt().matrixL();
    const Motion back = inverse(there);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    const int samples = 40000;
    for (int k = 0; k < samples; ++k) {
        const double a = normal(random), b = normal(random), c = normal(random);
        const Eigen::Vector3d e = root * Eigen::Vector3d(a, b, c);
        const Pose2 T = Pose2{there.T_before_now.x_m + e.x(), there.T_before_now.y_m + e.y(),
                              there.T_before_now.phi_rad + e.z()}
                            .inverse();
        const Eigen::Vector3d d(T.x_m - back.T_before_now.x_m, T.y_m - back.T_before_now.y_m,
                                wrap_to_pi(T.phi_rad - back.T_before_now.phi_rad));
        scatter += d * d.transpose() / samples;
    }
    EXPECT_LT((scatter - back.covariance).norm(), 0.03 * back.covariance.norm());
}

TEST(FusionOfPasses, linear_weights_go_from_the_forward_to_the_reverse_path_on_the_circle) {
    PassResult forward, reverse;
    for (int k = 0; k < 5; ++k) {
        forward.poses.push_back({1.0 * k, 0, M_PI - 0.1});
        reverse.poses.push_back({1.0 * k, 0.4, -M_PI + 0.1});
        forward.covariances.push_back(Eigen::Matrix3d::Identity());
        reverse.covariances.push_back(Eigen::Matrix3d::Identity());
    }
    const PassResult fused = fuse(forward, reverse, Weights::linear);
    for (int k = 0; k < 5; ++k) {
        const Pose2& T = fused.poses[static_cast<std::size_t>(k)];
        EXPECT_NEAR(T.x_m, k, 1e-12);
        EXPECT_NEAR(T.y_m, 0.1 * k, 1e-12);
        EXPECT_NEAR(wrap_to_pi(T.phi_rad - (M_PI - 0.1 + 0.05 * k)), 0, 1e-12);
    }
}

/// The two-filter smoother of one loop is the least-squares optimum of its chain: their equality to the
/// second order of the misclosure.
TEST(FusionOfPasses, covariance_weights_give_the_optimum_of_the_chain) {
    const std::size_t n = 24;
    std::vector<Motion> steps;
    std::vector<Pose2> path{{}};
    std::vector<Constraint> constraints;
    for (std::size_t k = 0; k < n; ++k) {
        steps.push_back(step_of_loop(k, 2e-4));
        path.push_back(path.back() * steps.back().T_before_now);
        constraints.push_back({static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(k + 1),
                               steps.back().T_before_now, steps.back().covariance.inverse(),
                               Constraint::Kind::motion});
    }
    const Eigen::Matrix3d loop_covariance = Eigen::Vector3d(2e-5, 3e-5, 1e-6).asDiagonal();
    const Pose2 T_map_last{path.back().x_m + 0.02, path.back().y_m - 0.015, path.back().phi_rad - 0.004};
    constraints.push_back(
        {0, static_cast<std::uint32_t>(n), T_map_last, loop_covariance.inverse(), Constraint::Kind::motion});

    PassResult forward, reverse;
    Motion so_far;
    for (std::size_t k = 0; k <= n; ++k) {
        forward.poses.push_back(so_far.T_before_now);
        forward.covariances.push_back(so_far.covariance);
        if (k < n) so_far = so_far * steps[k];
    }
    Motion back{T_map_last, loop_covariance};
    reverse.poses.resize(n + 1);
    reverse.covariances.resize(n + 1);
    for (std::size_t k = n + 1; k-- > 0;) {
        reverse.poses[k] = back.T_before_now;
        reverse.covariances[k] = back.covariance;
        if (k > 0) back = back * inverse(steps[k - 1]);
    }
    const PassResult fused = fuse(forward, reverse, Weights::covariance);

    GraphOptimiser optimiser(path, constraints, {30, 1e-10, 3});
    while (optimiser.iterate()) {
    }
    ASSERT_TRUE(optimiser.good());
    const auto covariances = optimiser.covariances();
    for (std::size_t k = 1; k <= n; ++k) {
        EXPECT_LT((fused.poses[k].translation() - optimiser.poses()[k].translation()).norm(), 2e-4) << k;
        EXPECT_NEAR(fused.poses[k].phi_rad, optimiser.poses()[k].phi_rad, 5e-5) << k;
        EXPECT_LT((fused.covariances[k] - covariances[k]).norm(), 0.02 * covariances[k].norm()) << k;
    }
}

}  // namespace
