/// The likelihood of a drive's noise against a dense normal distribution of all observations, its derivatives
/// against differences, and what is said about a calibration.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "api/dense_algebra.h"
#include "line_slam/calibration_section.h"
#include "line_slam/likeliest_noise.h"
#include "support/line_slam_world.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

/// Some metres in a room, straight and to the left, with a little noise of everything.
CalibrationGraph small_drive(int pieces, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    CalibrationGraph graph;
    const auto walls = test::polygon({{-6, -6}, {6, -6}, {6, 6}, {-6, 6}});
    for (const auto& wall : walls) graph.lines.push_back(wall.line());
    graph.track_width_m = 0.35;
    Pose2 T{-2, -2, 0};
    graph.poses.push_back(T);
    graph.velocities.emplace_back();
    graph.pieces.emplace_back();
    int stretch = -1;
    for (int k = 1; k <= pieces; ++k) {
        const Regime regime = k % 8 < 5 ? Regime::straight : Regime::left;
        if (stretch < 0 || graph.pieces.back().drive.regime != regime) ++stretch;
        const WheelTravel rolled =
            regime == Regime::straight ? WheelTravel{0.1, 0.1, 0} : WheelTravel{0.03, 0.08, 0};
        T = T * moved({0.98 * rolled.left_m + 0.001 * normal(random), rolled.right_m + 0.001 * normal(random),
                       0.001 * normal(random)},
                      graph.track_width_m);
        graph.poses.push_back(T);
        graph.velocities.push_back(log_se2(moved(rolled, graph.track_width_m)) * 10);
        graph.pieces.push_back({{regime, rolled, 0.1}, stretch});
        for (std::size_t w = 0; w < walls.size(); ++w) {
            LineObservation z;
            if (!test::view(walls[w], T, 15, z)) continue;
            test::disturb(z, 0.005, random);
            graph.observations.push_back({k, static_cast<int>(w), z.line, z.covariance.inverse()});
        }
    }
    // The second half of the drive sees another patch of each wall.
    for (int w = 0; w < static_cast<int>(walls.size()); ++w) {
        const int patch = static_cast<int>(graph.lines.size());
        graph.lines.push_back(graph.lines[static_cast<std::size_t>(w)]);
        graph.ties.push_back({w, patch, Eigen::Vector2d(1e6, 1e5).asDiagonal()});
        for (GraphObservation& z : graph.observations)
            if (z.line == w && 2 * z.pose > pieces) z.line = patch;
    }
    graph.deviations.resize(static_cast<std::size_t>(stretch) + 1);
    // So that all stays nearly linear, which the comparisons presume.
    graph.sigma_slip = 0.02;
    graph.sigma_track = 0.01;
    graph.sigma_delay_s = 0.01;
    return graph;
}

NoiseVector some_noise() {
    NoiseVector log_variance;
    log_variance.head<wheel_kinds>().setConstant(2 * std::log(0.003));
    log_variance(side_noise) = 2 * std::log(0.004);
    log_variance(rest_noise) = 2 * std::log(0.0003);
    log_variance.tail<wheel_kinds>().setConstant(2 * std::log(0.02));
    return log_variance;
}

/// All that is random, as one vector: noise of each piece (left, right, side), deviations, slips and track;
/// then the walls, which are not.
class DenseDrive {
 public:
    explicit DenseDrive(const CalibrationGraph& graph) : graph_(graph) {}

    Eigen::Index pieces() const { return static_cast<Eigen::Index>(graph_.pieces.size()) - 1; }
    Eigen::Index stretches() const { return static_cast<Eigen::Index>(graph_.deviations.size()); }
    Eigen::Index observations() const {
        return 2 * static_cast<Eigen::Index>(graph_.observations.size() + graph_.ties.size());
    }
    Eigen::Index randoms() const { return 3 * pieces() + 2 * stretches() + scale_count; }
    Eigen::Index size() const { return randoms() + 2 * static_cast<Eigen::Index>(graph_.lines.size()); }

    /// The values of all at `least`, which has moved from where this drive's own graph is.
    Eigen::VectorXd values_at(const CalibrationGraph& least) const {
        Eigen::VectorXd x = Eigen::VectorXd::Zero(size());
        for (Eigen::Index c = 0; c < stretches(); ++c)
            for (const Wheel wheel : both_wheels)
                x(3 * pieces() + 2 * c + static_cast<int>(wheel)) =
                    of(least.deviations[static_cast<std::size_t>(c)], wheel);
        const Eigen::Index scales = randoms() - scale_count;
        for (const Regime regime : all_regimes)
            for (const Wheel wheel : both_wheels)
                x(scales + wheel_noise(regime, wheel)) = of(least.slip, regime, wheel);
        x(scales + track_scale) = least.track;
        x(scales + delay_scale) = least.delay_s;
        for (std::size_t l = 0; l < graph_.lines.size(); ++l)
            x.segment<2>(randoms() + 2 * static_cast<Eigen::Index>(l)) =
                innovation(least.lines[l], graph_.lines[l]);
        for (Eigen::Index k = 0; k < pieces(); ++k) {
            const auto at = static_cast<std::size_t>(k);
            const WheelTravel went =
                wheel_travel(least.poses[at].inverse() * least.poses[at + 1], graph_.track_width_m);
            const WheelTravel expected = expected_travel_of(k, x);
            x.segment<3>(3 * k) << went.left_m - expected.left_m, went.right_m - expected.right_m,
                went.side_m;
        }
        return x;
    }

    /// Observed minus predicted for values of all.
    Eigen::VectorXd residual(const Eigen::VectorXd& x) const {
        std::vector<Pose2> poses{graph_.poses[0]};
        for (Eigen::Index k = 0; k < pieces(); ++k) {
            const WheelTravel t = expected_travel_of(k, x);
            poses.push_back(
                poses.back() *
                moved({t.left_m + x(3 * k), t.right_m + x(3 * k + 1), x(3 * k + 2)}, graph_.track_width_m));
        }
        const auto line = [&](int l) {
            const PlanarLine& at = graph_.lines[static_cast<std::size_t>(l)];
            return PlanarLine{at.rho_m + x(randoms() + 2 * l), at.alpha_rad + x(randoms() + 2 * l + 1)};
        };
        Eigen::VectorXd r(observations());
        for (std::size_t o = 0; o < graph_.observations.size(); ++o) {
            const GraphObservation& z = graph_.observations[o];
            const auto at = static_cast<std::size_t>(z.pose);
            const Pose2 T_map_seen =
                poses[at] * exp_se2(graph_.velocities[at] * x(randoms() - scale_count + delay_scale));
            r.segment<2>(2 * static_cast<Eigen::Index>(o)) =
                innovation(z.observed_base, predicted_line(T_map_seen, line(z.line)));
        }
        // That patch and wall are one is one more observation.
        for (std::size_t t = 0; t < graph_.ties.size(); ++t)
            r.segment<2>(2 * static_cast<Eigen::Index>(graph_.observations.size() + t)) =
                innovation(line(graph_.ties[t].wall), line(graph_.ties[t].patch));
        return r;
    }

    /// Linearised at `x`: minus twice the logarithm of the restricted likelihood, up to a constant.
    double minus_two_log_likelihood(const Eigen::VectorXd& x, const NoiseVector& log_variance) const {
        Eigen::MatrixXd J(observations(), size());
        for (Eigen::Index i = 0; i < size(); ++i) {
            Eigen::VectorXd a = x, b = x;
            a(i) += 1e-6, b(i) -= 1e-6;
            J.col(i) = -(residual(a) - residual(b)) / 2e-6;
        }
        const Eigen::MatrixXd random = J.leftCols(randoms()), walls = J.rightCols(size() - randoms());
        Eigen::MatrixXd V = random * variances(log_variance).asDiagonal() * random.transpose();
        for (std::size_t o = 0; o < graph_.observations.size(); ++o)
            V.block<2, 2>(2 * static_cast<Eigen::Index>(o), 2 * static_cast<Eigen::Index>(o)) +=
                graph_.observations[o].information.inverse();
        for (std::size_t t = 0; t < graph_.ties.size(); ++t)
            V.bottomRightCorner(2 * static_cast<Eigen::Index>(graph_.ties.size() - t),
                                2 * static_cast<Eigen::Index>(graph_.ties.size() - t))
                .topLeftCorner<2, 2>() += graph_.ties[t].information.inverse();
        const Eigen::VectorXd v = residual(x) + J * x;
        const Eigen::LDLT<Eigen::MatrixXd> of_V(V);
        const Eigen::MatrixXd of_walls = walls.transpose() * of_V.solve(walls);
        const Eigen::VectorXd pull = walls.transpose() * of_V.solve(v);
        return of_V.vectorD().array().log().sum() + of_walls.ldlt().vectorD().array().log().sum() +
               v.dot(of_V.solve(v)) - squared_in_sigmas(pull, of_walls);
    }

 private:
    /// Without noise, as wheels of the stated track width would do it.
    WheelTravel expected_travel_of(Eigen::Index k, const Eigen::VectorXd& x) const {
        const Eigen::Index deviations = 3 * pieces(), scales = deviations + 2 * stretches();
        const auto& [drive, stretch] = graph_.pieces[static_cast<std::size_t>(k) + 1];
        WheelValues ground_m;
        for (const Wheel wheel : both_wheels)
            of(ground_m, wheel) = (1 - x(scales + wheel_noise(drive.regime, wheel)) -
                                   x(deviations + 2 * stretch + static_cast<int>(wheel))) *
                                  of(drive.rolled, wheel);
        return wheel_travel(
            moved({ground_m[0], ground_m[1], 0}, graph_.track_width_m, {0, 0, x(scales + track_scale)}),
            graph_.track_width_m);
    }

    Eigen::VectorXd variances(const NoiseVector& log_variance) const {
        Eigen::VectorXd Q(randoms());
        const double rest = std::exp(log_variance(rest_noise));
        for (Eigen::Index k = 0; k < pieces(); ++k) {
            const auto& [drive, stretch] = graph_.pieces[static_cast<std::size_t>(k) + 1];
            for (const Wheel wheel : both_wheels) {
                const auto w = static_cast<Eigen::Index>(wheel);
                Q(3 * k + w) =
                    rest + std::exp(log_variance(wheel_noise(drive.regime, wheel))) * of(drive.rolled, wheel);
                Q(3 * pieces() + 2 * stretch + w) = std::exp(log_variance(slip_scatter(drive.regime, wheel)));
            }
            Q(3 * k + 2) = rest + std::exp(log_variance(side_noise)) * mean_way_m(drive.rolled);
        }
        Q.tail(scale_count).setConstant(graph_.sigma_slip * graph_.sigma_slip);
        Q(randoms() - scale_count + track_scale) = graph_.sigma_track * graph_.sigma_track;
        Q(randoms() - scale_count + delay_scale) = graph_.sigma_delay_s * graph_.sigma_delay_s;
        return Q;
    }

    const CalibrationGraph& graph_;
};

struct Values {
    double sparse, dense;
};

/// Both at the minimum for this noise.
Values values(const CalibrationGraph& graph, const NoiseVector& log_variance) {
    CalibrationGraph least = graph;
    CalibrationSolver solver(least);
    EXPECT_TRUE(solver.minimise(least, log_variance));
    const DenseDrive dense(graph);
    return {solver.minus_two_log_likelihood(least, log_variance),
            dense.minus_two_log_likelihood(dense.values_at(least), log_variance)};
}

double sparse_value(const CalibrationGraph& graph, const NoiseVector& log_variance) {
    CalibrationGraph least = graph;
    CalibrationSolver solver(least);
    EXPECT_TRUE(solver.minimise(least, log_variance));
    return solver.minus_two_log_likelihood(least, log_variance);
}

TEST(LineSlamCalibration, likelihood_is_that_of_all_observations_together) {
    const CalibrationGraph graph = small_drive(24, 1);
    const NoiseVector first = some_noise();
    const Values at_first = values(graph, first);
    std::mt19937_64 random(2);
    std::normal_distribution<double> normal;
    double largest = 0;
    for (int i = 0; i < 20; ++i) {
        NoiseVector other = first;
        for (int c = 0; c < noise_count; ++c) other(c) += normal(random);
        const Values at_other = values(graph, other);
        EXPECT_NEAR(at_other.sparse - at_first.sparse, at_other.dense - at_first.dense, 0.01);
        largest = std::max(largest, std::abs(at_other.dense - at_first.dense));
    }
    EXPECT_GT(largest, 10) << "the comparison must have something to compare";
}

TEST(LineSlamCalibration, gradient_agrees_with_central_differences) {
    CalibrationGraph graph = small_drive(80, 3);
    const NoiseVector at = some_noise();
    CalibrationSolver solver(graph);
    ASSERT_TRUE(solver.minimise(graph, at));
    const auto likelihood = solver.likelihood(graph, at);
    EXPECT_NEAR(likelihood.minus_two_log, sparse_value(graph, at), 1e-3);
    for (int c = 0; c < noise_count; ++c) {
        NoiseVector a = at, b = at;
        a(c) += 0.01, b(c) -= 0.01;
        const double slope = -0.5 * (sparse_value(graph, a) - sparse_value(graph, b)) / 0.02;
        EXPECT_NEAR(likelihood.gradient(c), slope, 0.05 * std::abs(slope) + 0.02) << c;
    }
    // No turn to the right.
    for (const Wheel wheel : both_wheels)
        EXPECT_EQ(likelihood.gradient(wheel_noise(Regime::right, wheel)), 0);
}

/// At the maximum, where the average information stands for the curvature.
TEST(LineSlamCalibration, information_is_about_the_curvature) {
    NoisePrior prior;
    prior.mean = some_noise();
    prior.information = NoiseMatrix::Identity();
    NoiseMatrix information = NoiseMatrix::Zero(), curvature = NoiseMatrix::Zero();
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        CalibrationGraph graph = small_drive(300, seed);
        CalibrationSolver solver(graph);
        const NoiseEstimate noise = likeliest_noise(solver, graph, prior.mean, prior);
        ASSERT_TRUE(noise.good);
        information += solver.likelihood(graph, noise.log_variance).information;
        for (int c = 0; c < noise_count; ++c) {
            NoiseVector gradients[2];
            for (const int side : {0, 1}) {
                NoiseVector near = noise.log_variance;
                near(c) += side == 0 ? -0.05 : 0.05;
                CalibrationGraph moved_graph = graph;
                ASSERT_TRUE(solver.minimise(moved_graph, near));
                gradients[side] = solver.likelihood(moved_graph, near).gradient;
            }
            curvature.col(c) -= (gradients[1] - gradients[0]) / 0.1;
        }
    }
    for (const int c :
         {wheel_noise(Regime::straight, Wheel::left), wheel_noise(Regime::straight, Wheel::right),
          wheel_noise(Regime::left, Wheel::right), side_noise})
        EXPECT_NEAR(information(c, c) / curvature(c, c), 1, 0.3) << c;
}

DriveCalibration plain_calibration() {
    DriveCalibration found;
    found.good = true;
    found.track_width_m = {0.5, 0.2};
    found.sigma_side_m = {0.01, 0.001};
    found.sigma_rest_m = {1e-4, 1e-5};
    for (std::size_t r = 0; r < regime_count; ++r) {
        found.amounts[r] = {100, 5, 50.0, {10.0, 10.0}, {2.0, 2.0}, {{{0.2, 0.01}, {0.3, 0.01}}}};
        found.wheels[r].fill({{0.1, 0.01}, {0.02, 0.002}, {0.015, 0.002}, {1e-4, 1e-3}});
    }
    return found;
}

std::map<std::string, CalibratedKey> keys_of(const DriveCalibration& found, const CalibratedRun& run) {
    std::map<std::string, CalibratedKey> keys;
    for (const CalibratedKey& key : calibration_section(found, run).keys) keys[key.key] = key;
    return keys;
}

TEST(LineSlamCalibration, a_key_that_the_log_tells_no_better_is_left_out) {
    DriveCalibration found = plain_calibration();
    found.wheels[1][0].slip = {0.1, 0.3};       // nobody knows
    found.wheels[1][1].slip = {0.7, 0.3};       // not well known, but not 0 either
    found.wheels[2][0].sigma_m = {0.01, 0.02};  // nobody knows
    found.wheels[2][1].scatter = {0.05, 0.01};  // worth a word
    const auto keys = keys_of(found, {});
    EXPECT_FALSE(keys.at("turn_left_slip_left").value);
    EXPECT_NE(keys.at("turn_left_slip_left").comment.find("standard error of 0.3"), std::string::npos);
    EXPECT_EQ(keys.at("turn_left_slip_right").value, 0.7);
    EXPECT_EQ(keys.at("straight_slip_left").standard_error, 0.01);
    EXPECT_EQ(keys.at("straight_slip_left").comment, "10.0 m in 50.0 s, 100 steps in 5 stretches");
    EXPECT_FALSE(keys.at("turn_right_sigma_left_m").value);
    EXPECT_NE(keys.at("turn_right_sigma_right_m").comment.find("scatters by 0.05"), std::string::npos);
    EXPECT_FALSE(keys.at("track_width_m").value);
    EXPECT_EQ(keys.count("odometry_track_width_m"), 0u);
    EXPECT_EQ(keys.count("straight_left_mps"), 0u) << "nobody commanded a regime";
}

TEST(LineSlamCalibration, a_track_width_comes_with_the_one_that_the_odometry_had) {
    DriveCalibration found = plain_calibration();
    found.track_told = true;
    found.track_width_m = {0.45, 0.004};
    const auto keys = keys_of(found, {});
    EXPECT_EQ(keys.at("track_width_m").value, 0.45);
    EXPECT_EQ(keys.at("odometry_track_width_m").value, 0.5);
    EXPECT_EQ(keys.at("odometry_track_width_m").standard_error, 0);
    CalibratedRun again;
    again.drive.track_width_m = 0.46;
    again.drive.odometry_track_width_m = 0.5;
    EXPECT_EQ(keys_of(found, again).at("odometry_track_width_m").value, 0.5)
        << "calibrating what is calibrated";
}

TEST(LineSlamCalibration, speeds_are_those_over_ground_where_they_are_the_control) {
    CalibratedRun run;
    run.regimes_from_log = true;
    run.regimes[0].commanded = {0.1, 0.2};
    auto keys = keys_of(plain_calibration(), run);
    EXPECT_EQ(keys.at("straight_left_mps").value, 0.2) << "of the rim";
    EXPECT_EQ(keys.at("straight_slip_left").value, 0.1);
    run.control = IntervalParameters::Control::commanded;
    keys = keys_of(plain_calibration(), run);
    EXPECT_NEAR(keys.at("straight_left_mps").value.value_or(0), 0.09, 1e-12);
    EXPECT_NEAR(keys.at("straight_right_mps").standard_error, 0.002, 1e-12);
    EXPECT_EQ(keys.at("straight_slip_left").value, 0.0);
}

TEST(LineSlamCalibration, amounts_are_sums_and_speeds_their_quotient) {
    std::vector<CalibrationGraph::Piece> pieces(1);
    const auto add = [&pieces](Regime regime, double left_m, double right_m, double duration_s) {
        const bool same = pieces.size() > 1 && pieces.back().drive.regime == regime;
        const int stretch = pieces.size() == 1 ? 0 : pieces.back().stretch + (same ? 0 : 1);
        pieces.push_back({{regime, {left_m, right_m, 0}, duration_s}, stretch});
    };
    add(Regime::straight, 1, 1.1, 2);
    add(Regime::straight, 1, 1.1, 2);
    add(Regime::left, -0.1, 0.3, 1);
    add(Regime::straight, 0.8, 1, 2);
    const RegimeAmounts amounts = amounts_of(pieces);
    EXPECT_EQ(amounts[0].steps, 3);
    EXPECT_EQ(amounts[0].stretches, 2);
    EXPECT_DOUBLE_EQ(amounts[0].duration_s, 6);
    EXPECT_DOUBLE_EQ(amounts[0].speed_mps[0].value, 2.8 / 6);
    // Deviations of the stretches' ways: 2 - 4 v and 0.8 - 2 v, which is minus that.
    const double off_m = 2 - 4 * 2.8 / 6;
    EXPECT_NEAR(amounts[0].speed_mps[0].standard_error, std::sqrt(2 * off_m * off_m * 2) / 6, 1e-12);
    EXPECT_DOUBLE_EQ(amounts[1].rolled_m[0], 0.1);
    EXPECT_DOUBLE_EQ(amounts[1].speed_mps[0].value, -0.1);
    EXPECT_EQ(amounts[2].steps, 0);
}

}  // namespace
