/// The pose graph and what is derived from its constraints: against central differences, dense inverses,
/// brute force and Monte Carlo.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

#include "grid_slam/motion.h"
#include "grid_slam/pose_graph.h"
#include "grid_slam/relative_uncertainty.h"

using namespace loopline;
using namespace loopline::grid_slam;

namespace {

Eigen::Matrix3d random_covariance(std::mt19937_64& random, double sigma_m, double sigma_rad) {
    std::uniform_real_distribution<double> unit(-1, 1);
    Eigen::Matrix3d A;
    for (int k = 0; k < 9; ++k) A(k / 3, k % 3) = unit(random);
    const Eigen::Matrix3d C = 0.5 * Eigen::Matrix3d::Identity() + 0.5 * A * A.transpose();
    const Eigen::Vector3d sigma(sigma_m, sigma_m, sigma_rad);
    return sigma.asDiagonal() * C * sigma.asDiagonal();
}

Eigen::Vector3d sample(const Eigen::Matrix3d& covariance, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const double a = normal(random), b = normal(random), c = normal(random);
    return covariance.llt().matrixL() * Eigen::Vector3d(a, b, c);
}

/// Adds to the components, along the axes of the frame that the pose is given in.
Pose2 disturbed(const Pose2& T, const Eigen::Vector3d& by) {
    return {T.x_m + by.x(), T.y_m + by.y(), wrap_to_pi(T.phi_rad + by.z())};
}

struct Graph {
    std::vector<Pose2> poses;
    std::vector<Constraint> constraints;
};

Constraint between(const Graph& g, std::uint32_t from, std::uint32_t to, Constraint::Kind kind, double noise,
                   std::mt19937_64& random) {
    const Eigen::Matrix3d covariance = random_covariance(random, 0.02, 0.01);
    Constraint c;
    c.from = from;
    c.to = to;
    c.kind = kind;
    c.T_from_to = disturbed(g.poses[from].inverse() * g.poses[to], noise * sample(covariance, random));
    c.information = covariance.inverse();
    return c;
}

/// A wandering path that comes by earlier places; constraints in both directions.
Graph random_loop(int size, double noise, std::mt19937_64& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    Graph g;
    Pose2 T;
    for (int k = 0; k < size; ++k) {
        g.poses.push_back(T);
        T = T * Pose2{0.5, 0.1 * unit(random), 2 * M_PI / 25 + 0.2 * unit(random)};
    }
    for (std::uint32_t k = 1; k < g.poses.size(); ++k)
        g.constraints.push_back(between(g, k - 1, k, Constraint::Kind::motion, noise, random));
    for (std::uint32_t k = 25; k < g.poses.size(); k += 3)
        g.constraints.push_back(
            between(g, k % 2 ? k : k - 25, k % 2 ? k - 25 : k, Constraint::Kind::loop, noise, random));
    return g;
}

std::vector<Pose2> perturbed(std::vector<Pose2> poses, double by_m, double by_rad, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    for (std::size_t k = 1; k < poses.size(); ++k) {
        const double x = normal(random), y = normal(random), phi = normal(random);
        poses[k] = disturbed(poses[k], {by_m * x, by_m * y, by_rad * phi});
    }
    return poses;
}

std::vector<Pose2> optimum(const std::vector<Pose2>& start, const Graph& g, int iterations = 60) {
    GraphOptimiser optimiser(start, g.constraints, {iterations, 1e-9, 3});
    while (optimiser.iterate()) {
    }
    EXPECT_TRUE(optimiser.good());
    return optimiser.poses();
}

double farthest_apart(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
    double most = 0;
    for (std::size_t k = 0; k < a.size(); ++k)
        most = std::max({most, (a[k].translation() - b[k].translation()).norm(),
                         std::abs(wrap_to_pi(a[k].phi_rad - b[k].phi_rad))});
    return most;
}

double cost(const std::vector<Pose2>& poses, const std::vector<Constraint>& constraints) {
    double sum = 0;
    for (const Constraint& c : constraints) {
        const Eigen::Vector3d e = residual(c, poses[c.from], poses[c.to]);
        const double square = e.dot(c.information * e);
        sum += c.kind == Constraint::Kind::motion ? square : 9 * std::log1p(square / 9);
    }
    return sum;
}

TEST(PoseGraph, residual_is_what_a_pose_is_off_in_the_frame_of_the_other) {
    std::mt19937_64 random(1);
    Graph g = random_loop(60, 0, random);
    for (Constraint& c : g.constraints) {
        EXPECT_LT(residual(c, g.poses[c.from], g.poses[c.to]).norm(), 1e-9);
        const Eigen::Vector3d off(0.1, -0.2, 3);
        const Pose2 T = g.poses[c.from] * disturbed(c.T_from_to, off);
        EXPECT_LT((residual(c, g.poses[c.from], T) - off).norm(), 1e-9);
    }
}

TEST(PoseGraph, covariances_are_the_dense_inverse_by_central_differences) {
    std::mt19937_64 random(2);
    for (int run = 0; run < 10; ++run) {
        const Graph g = random_loop(40, 0, random);  // no residuals: every loop counts fully
        const Eigen::Index n = static_cast<Eigen::Index>(3 * (g.poses.size() - 1));
        Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
        for (const Constraint& c : g.constraints) {
            Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, n);
            for (const std::uint32_t pose : {c.from, c.to})
                for (int k = 0; pose > 0 && k < 3; ++k) {
                    std::vector<Pose2> more = g.poses, less = g.poses;
                    more[pose] = disturbed(more[pose], 1e-6 * Eigen::Vector3d::Unit(k));
                    less[pose] = disturbed(less[pose], -1e-6 * Eigen::Vector3d::Unit(k));
                    J.col(3 * (static_cast<Eigen::Index>(pose) - 1) + k) =
                        (residual(c, more[c.from], more[c.to]) - residual(c, less[c.from], less[c.to])) /
                        2e-6;
                }
            H += J.transpose() * c.information * J;
        }
        const Eigen::MatrixXd dense = H.inverse();
        GraphOptimiser optimiser(g.poses, g.constraints, {});
        const auto found = optimiser.covariances();
        ASSERT_EQ(found.size(), g.poses.size());
        EXPECT_EQ(found[0], Eigen::Matrix3d::Zero());
        for (std::size_t k = 1; k < g.poses.size(); ++k) {
            const auto at = static_cast<Eigen::Index>(3 * (k - 1));
            const Eigen::Matrix3d expected = dense.block<3, 3>(at, at);
            EXPECT_LT((found[k] - expected).norm(), 1e-6 * expected.norm()) << k;
        }
    }
}

TEST(PoseGraph, finds_exact_loops_again_from_perturbed_starts) {
    std::mt19937_64 random(3);
    for (int run = 0; run < 20; ++run) {
        const Graph g = random_loop(80, 0, random);
        EXPECT_LT(farthest_apart(optimum(perturbed(g.poses, 0.02, 0.02, random), g), g.poses), 1e-6) << run;
    }
}

TEST(PoseGraph, optimum_has_no_slope_and_does_not_depend_on_the_start) {
    std::mt19937_64 random(4);
    for (int run = 0; run < 10; ++run) {
        const Graph g = random_loop(60, 1, random);
        const auto best = optimum(g.poses, g);
        EXPECT_LT(farthest_apart(optimum(perturbed(g.poses, 0.02, 0.02, random), g), best), 1e-5) << run;
        const double least = cost(best, g.constraints);
        for (std::size_t k = 1; k < best.size(); k += 5)
            for (int axis = 0; axis < 3; ++axis)
                for (const double step : {1e-3, -1e-3}) {
                    auto near = best;
                    near[k] = disturbed(near[k], step * Eigen::Vector3d::Unit(axis));
                    EXPECT_GT(cost(near, g.constraints), least) << run;
                }
    }
}

TEST(PoseGraph, covariances_cover_the_errors) {
    double sum = 0;
    const int runs = 100;
    for (int run = 0; run < runs; ++run) {
        std::mt19937_64 random(100 + static_cast<std::uint64_t>(run));
        Graph g = random_loop(40, 1, random);
        GraphOptimiser optimiser(g.poses, g.constraints, {20, 1e-8, 100});  // nothing to be robust against
        while (optimiser.iterate()) {
        }
        const Pose2 &found = optimiser.poses().back(), &truth = g.poses.back();
        const Eigen::Vector3d e(found.x_m - truth.x_m, found.y_m - truth.y_m,
                                wrap_to_pi(found.phi_rad - truth.phi_rad));
        sum += e.dot(optimiser.covariances().back().inverse() * e);
    }
    // 95 % band of chi-square with 300 degrees of freedom, over 100.
    EXPECT_GT(sum / runs, 2.54);
    EXPECT_LT(sum / runs, 3.50);
}

TEST(PoseGraph, refuses_what_has_no_solution) {
    EXPECT_FALSE(GraphOptimiser({}, {}, {}).iterate());
    EXPECT_FALSE(GraphOptimiser({{}}, {}, {}).iterate());
    Constraint c;  // no information: the second pose is free
    c.to = 1;
    GraphOptimiser free({{}, {1, 0, 0}}, {c}, {});
    EXPECT_FALSE(free.iterate());
    EXPECT_FALSE(free.good());
    EXPECT_TRUE(free.covariances().empty());
}

TEST(Motion, composition_carries_the_covariance) {
    std::mt19937_64 random(5);
    for (int run = 0; run < 3; ++run) {
        const Motion a{{1, 0.5, 0.7 * run}, random_covariance(random, 0.02, 0.01)},
            b{{2, -1, -0.5}, random_covariance(random, 0.03, 0.02)},
            c{{0.5, 1, 2}, random_covariance(random, 0.01, 0.03)};
        const Motion all = a * b * c;
        Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
        const int samples = 40000;
        for (int k = 0; k < samples; ++k) {
            const Pose2 T = disturbed(a.T_before_now, sample(a.covariance, random)) *
                            disturbed(b.T_before_now, sample(b.covariance, random)) *
                            disturbed(c.T_before_now, sample(c.covariance, random));
            const Eigen::Vector3d e(T.x_m - all.T_before_now.x_m, T.y_m - all.T_before_now.y_m,
                                    wrap_to_pi(T.phi_rad - all.T_before_now.phi_rad));
            scatter += e * e.transpose() / samples;
        }
        const Eigen::Vector3d per_sigma = scatter.diagonal().cwiseSqrt().cwiseInverse();
        const Eigen::Matrix3d apart =
            per_sigma.asDiagonal() * (all.covariance - scatter) * per_sigma.asDiagonal();
        EXPECT_LT(apart.cwiseAbs().maxCoeff(), 0.03) << run;
    }
}

double larger_axis(const Eigen::Matrix3d& c) {
    return (c(0, 0) + c(1, 1)) / 2 + std::hypot((c(0, 0) - c(1, 1)) / 2, c(0, 1));
}

/// The least variance over all ways that visit no frame twice.
void all_ways(const Neighbourhood& graph, const std::vector<Pose2>& poses, std::uint32_t at,
              const Eigen::Matrix3d& covariance, std::vector<bool>& visited, std::vector<double>& least) {
    least[at] = std::min(least[at], larger_axis(covariance));
    visited[at] = true;
    for (const auto& edge : graph.of(at)) {
        if (visited[edge.other]) continue;
        Eigen::Matrix3d carried = Eigen::Matrix3d::Identity();
        carried(0, 2) = -(poses[edge.other].y_m - poses[at].y_m);
        carried(1, 2) = poses[edge.other].x_m - poses[at].x_m;
        all_ways(graph, poses, edge.other, carried * covariance * carried.transpose() + edge.covariance,
                 visited, least);
    }
    visited[at] = false;
}

TEST(RelativeUncertainty, is_that_of_the_best_chain) {
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int run = 0; run < 60; ++run) {
        const bool only_position =
            run % 2 == 0;  // then variances add up, and the best chain is found for certain
        const std::uint32_t size = 7;
        Graph g;
        for (std::uint32_t k = 0; k < size; ++k)
            g.poses.push_back({5 * unit(random), 5 * unit(random), 6 * unit(random)});
        Neighbourhood graph;
        graph.resize(size);
        for (int k = 0; k < 11; ++k) {
            Constraint c;
            c.from = static_cast<std::uint32_t>(random() % size);
            c.to = static_cast<std::uint32_t>(random() % size);
            if (c.from == c.to) continue;
            const double sigma_m = 0.01 + 0.1 * unit(random);
            c.information = only_position
                                ? Eigen::Vector3d(1 / (sigma_m * sigma_m), 1 / (sigma_m * sigma_m), 1e14)
                                      .asDiagonal()
                                      .toDenseMatrix()
                                : Eigen::Matrix3d(random_covariance(random, sigma_m, 0.05).inverse());
            graph.add(c, g.poses[c.from]);
        }
        std::vector<double> least(size, RelativeUncertainty::unknown);
        std::vector<bool> visited(size, false);
        all_ways(graph, g.poses, 0, Eigen::Matrix3d::Zero(), visited, least);
        RelativeUncertainty found;
        relative_uncertainty(graph, g.poses, 0, RelativeUncertainty::unknown, found);
        for (std::uint32_t k = 0; k < size; ++k) {
            if (!std::isfinite(least[k])) {
                EXPECT_EQ(found.variance_m2[k], RelativeUncertainty::unknown);
                continue;
            }
            if (only_position) {
                EXPECT_NEAR(found.variance_m2[k], least[k], 1e-6 * least[k] + 1e-12);
            } else {
                EXPECT_GE(found.variance_m2[k], least[k] * (1 - 1e-9));
            }
        }
        // In order, and nothing beyond the limit.
        const double limit_m2 = 0.01;
        relative_uncertainty(graph, g.poses, 0, limit_m2, found);
        for (std::size_t k = 1; k < found.reached.size(); ++k) {
            EXPECT_GE(found.variance_m2[found.reached[k]],
                      found.variance_m2[found.reached[k - 1]] * (1 - 1e-9));
            EXPECT_LT(found.variance_m2[found.reached[k]], limit_m2);
        }
    }
}

void expect_no_less_than_all_constraints_leave(const Graph& g) {
    Neighbourhood graph;
    graph.resize(g.poses.size());
    for (const Constraint& c : g.constraints) graph.add(c, g.poses[c.from]);
    RelativeUncertainty chain;
    relative_uncertainty(graph, g.poses, 0, RelativeUncertainty::unknown, chain);
    GraphOptimiser optimiser(g.poses, g.constraints, {});
    const auto joint = optimiser.covariances();
    for (std::size_t k = 1; k < g.poses.size(); ++k)
        EXPECT_GT(chain.variance_m2[k], 0.99 * larger_axis(joint[k])) << k;
}

TEST(RelativeUncertainty, is_no_less_than_what_all_constraints_leave) {
    std::mt19937_64 random(7);
    Graph g = random_loop(60, 0, random);
    for (Constraint& c : g.constraints)
        if (c.from > c.to) c = between(g, c.to, c.from, c.kind, 0, random);
    expect_no_less_than_all_constraints_leave(g);
}

/// Not so yet: the error of a constraint's heading turns its own way where it is gone from `to` to `from`.
TEST(RelativeUncertainty, is_no_less_either_where_a_constraint_is_gone_backward) {
    std::mt19937_64 random(7);
    expect_no_less_than_all_constraints_leave(random_loop(60, 0, random));
}

TEST(RelativeUncertainty, along_a_chain_is_what_samples_scatter_by) {
    std::mt19937_64 random(8);
    Graph g = random_loop(25, 0, random);
    std::vector<Eigen::Matrix3d> covariances;
    Neighbourhood graph;
    graph.resize(g.poses.size());
    for (const Constraint& c : g.constraints) {
        covariances.push_back(c.information.inverse());
        graph.add(c, g.poses[c.from]);
    }
    // From the first frame to the last, and from the last back to the first.
    RelativeUncertainty forward, backward;
    const auto last = static_cast<std::uint32_t>(g.poses.size() - 1);
    relative_uncertainty(graph, g.poses, 0, RelativeUncertainty::unknown, forward);
    relative_uncertainty(graph, g.poses, last, RelativeUncertainty::unknown, backward);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero(), scatter_back = scatter;
    const int samples = 10000;
    for (int k = 0; k < samples; ++k) {
        Pose2 T = g.poses[0];
        for (std::size_t i = 0; i < g.constraints.size(); ++i)
            T = T * disturbed(g.constraints[i].T_from_to, sample(covariances[i], random));
        const Pose2 T_back = g.poses[last] * T.inverse() * g.poses[0];  // the first frame, given the last one
        const auto square = [](const Pose2& a, const Pose2& b) {
            const Eigen::Vector3d e(a.x_m - b.x_m, a.y_m - b.y_m, wrap_to_pi(a.phi_rad - b.phi_rad));
            return Eigen::Matrix3d(e * e.transpose());
        };
        scatter += square(T, g.poses[last]) / samples;
        scatter_back += square(T_back, g.poses[0]) / samples;
    }
    const auto apart = [](const Eigen::Matrix3d& claimed, const Eigen::Matrix3d& true_one) {
        const Eigen::Vector3d per_sigma = true_one.diagonal().cwiseSqrt().cwiseInverse();
        return Eigen::Matrix3d(per_sigma.asDiagonal() * (claimed - true_one) * per_sigma.asDiagonal())
            .cwiseAbs()
            .maxCoeff();
    };
    EXPECT_LT(apart(forward.covariance[last], scatter), 0.06);
    // Backward the way of each single constraint is not turned by its own heading's error, a step of many.
    EXPECT_LT(apart(backward.covariance[0], scatter_back), 0.12);
}

}  // namespace
