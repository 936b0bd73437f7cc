/// Least squares over path and lines: against truth, dense inverses and the definition of the gradient.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "api/dense_algebra.h"
#include "least_squares/selected_inverse.h"
#include "line_slam/pose_line_graph.h"
#include "support/line_slam_world.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

PoseLineGraph small_graph(double sigma_m, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    DriveParameters drive;
    drive.sigma_wheel_m *= sigma_m > 0 ? 1 : 1e-6;
    drive.sigma_side_m *= sigma_m > 0 ? 1 : 1e-6;
    drive.sigma_rest_m *= sigma_m > 0 ? 1 : 1e-6;
    PoseLineGraph graph;
    const auto walls = test::square_ring(20, 10);
    Pose2 T{-7.5, -7.5, 0};
    const Pose2 T_map_world = T.inverse();
    for (const auto& w : walls) graph.lines.push_back(transformed(T_map_world, w.line()));
    graph.poses.push_back({});
    graph.motions.push_back({});
    const DriveParameters stated;
    for (int k = 1; k < 60; ++k) {
        const WheelTravel truth = wheel_travel({0.5, 0, k % 15 == 0 ? M_PI / 2 : 0.0}, 0.5);
        T = T * moved(truth, 0.5);
        graph.poses.push_back(T_map_world * T);
        graph.motions.push_back(
            {test::measured(truth, drive, {}, random), travel_covariance(truth, stated).inverse()});
        for (int w = 0; w < static_cast<int>(walls.size()); ++w) {
            LineObservation z;
            if (!test::view(walls[static_cast<std::size_t>(w)], T, 8, z)) continue;
            LineObservation noisy = z;
            test::disturb(noisy, 0.02, random);
            graph.observations.push_back(
                {k, w, sigma_m > 0 ? noisy.line : z.line, noisy.covariance.inverse()});
        }
    }
    return graph;
}

TEST(LineSlamGraph, finds_the_truth_again_without_noise) {
    const PoseLineGraph truth = small_graph(0, 1);
    PoseLineGraph graph = truth;
    std::mt19937_64 random(2);
    std::normal_distribution<double> normal(0, 0.02);
    for (std::size_t k = 1; k < graph.poses.size(); ++k)
        graph.poses[k] = {graph.poses[k].x_m + normal(random), graph.poses[k].y_m + normal(random),
                          wrap_to_pi(graph.poses[k].phi_rad + 0.2 * normal(random))};
    for (PlanarLine& l : graph.lines)
        l = {l.rho_m + normal(random), wrap_to_pi(l.alpha_rad + 0.2 * normal(random))};
    graph.loss = CauchyLoss(100);
    GraphSolver solver(graph);
    const auto outcome = solver.minimise(graph, 50);
    EXPECT_LT(outcome.final_cost, 1e-3);
    for (std::size_t k = 0; k < graph.poses.size(); ++k)
        EXPECT_LT((graph.poses[k].translation() - truth.poses[k].translation()).norm(), 1e-3);
}

TEST(LineSlamGraph, minimum_has_no_slope) {
    PoseLineGraph graph = small_graph(1, 3);
    GraphSolver solver(graph);
    solver.minimise(graph, 100);
    const double least = graph_cost(graph);
    for (std::size_t k = 1; k < graph.poses.size(); k += 7)
        for (const double step : {1e-3, -1e-3}) {
            PoseLineGraph near = graph;
            near.poses[k].x_m += step;
            EXPECT_GT(graph_cost(near), least);
            near = graph;
            near.poses[k].phi_rad += step;
            EXPECT_GT(graph_cost(near), least);
        }
    for (std::size_t l = 0; l < graph.lines.size(); ++l) {
        PoseLineGraph near = graph;
        near.lines[l].alpha_rad += 1e-3;
        EXPECT_GE(graph_cost(near), least);  // equal for a wall that was never seen
    }
}

TEST(LineSlamGraph, selected_inverse_equals_the_dense_one) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (const int n : {1, 2, 17, 60}) {
        Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
        for (int k = 0; k < 3 * n; ++k) A(random() % n, random() % n) += uniform(random);
        const Eigen::MatrixXd H = A * A.transpose() + Eigen::MatrixXd::Identity(n, n);
        least_squares::SparseLdlt ldlt(Eigen::SparseMatrix<double>(H.sparseView()));
        const auto inverse = least_squares::selected_inverse(ldlt);
        const Eigen::MatrixXd dense = H.inverse();
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                if (H(i, j) != 0) {
                    EXPECT_NEAR(least_squares::selected_entry(inverse, ldlt, i, j), dense(i, j), 1e-10);
                }
    }
}

TEST(CauchyLoss, information_factor_makes_the_weighted_information_that_of_the_scatter) {
    // The estimated middle of 200 points, over 4000 times.
    std::mt19937_64 random(8);
    std::normal_distribution<double> normal(0, 1);
    for (const double scale : {1.5, 3.0, 6.0}) {
        const CauchyLoss loss(scale);
        double scatter = 0, claimed = 0;
        const int runs = 4000, n = 200;
        for (int run = 0; run < runs; ++run) {
            std::vector<Eigen::Vector2d> points;
            for (int i = 0; i < n; ++i) points.emplace_back(normal(random), normal(random));
            Eigen::Vector2d middle = Eigen::Vector2d::Zero();
            double information = 0;
            for (int iteration = 0; iteration < 12; ++iteration) {
                Eigen::Vector2d sum = Eigen::Vector2d::Zero();
                information = 0;
                for (const auto& p : points) {
                    const double w = loss.weight((p - middle).squaredNorm());
                    sum += w * p;
                    information += w;
                }
                middle = sum / information;
            }
            scatter += middle.squaredNorm() / 2;
            claimed += 1 / (loss.information_factor() * information);
        }
        EXPECT_NEAR(scatter / claimed, 1, 0.05) << scale;
    }
    EXPECT_NEAR(CauchyLoss(9.9).information_factor(), CauchyLoss(10.1).information_factor(), 0.03);
    EXPECT_EQ(CauchyLoss(1000).information_factor(), 1);
}

TEST(LineSlamGraph, covariances_cover_the_errors) {
    // Mean normalised error of the last pose over repetitions: three degrees of freedom.
    double sum = 0;
    const int runs = 60;
    for (int run = 0; run < runs; ++run) {
        const PoseLineGraph truth = small_graph(0, 1);
        PoseLineGraph graph = small_graph(1, 100 + static_cast<std::uint64_t>(run));
        graph.loss = CauchyLoss(100);  // nothing to be robust against
        GraphSolver solver(graph);
        solver.minimise(graph, 50);
        ASSERT_TRUE(solver.factorise(graph));
        const Eigen::Matrix3d covariance = solver.pose_covariances().back();
        const Pose2 &e = graph.poses.back(), &t = truth.poses.back();
        const Eigen::Vector3d error(e.x_m - t.x_m, e.y_m - t.y_m, wrap_to_pi(e.phi_rad - t.phi_rad));
        sum += squared_in_sigmas(error, covariance);
    }
    // 95 % band of chi-square with 180 degrees of freedom, over 60.
    EXPECT_GT(sum / runs, 2.41);
    EXPECT_LT(sum / runs, 3.65);
}

}  // namespace
