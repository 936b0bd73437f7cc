/// Pose and velocity of a sweep in the map of a spinning lidar.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <map>

#include "api/dense_algebra.h"
#include "lidar_mapping/shared_errors.h"
#include "support/lidar_yard.h"

using namespace loopline;
using namespace loopline::lidar_mapping;
using namespace loopline::lidar_yard;

namespace {

/// Steps as long as they are not lost in rounding.
RegistrationSettings to_the_end() {
    RegistrationSettings settings;
    settings.iterations = 50;
    settings.enough_m = 1e-6;
    settings.enough_rad = 1e-7;
    return settings;
}

MotionState predicted_near(const MotionState& truth) {
    Vector12d off;
    off << 0.05, -0.04, 0.03, 0.01, -0.005, 0.01, 0.3, -0.2, 0.1, 0.03, 0.05, -0.05;
    return state_near(truth, off, 1, 0.2);
}

TEST(Registration, finds_pose_and_velocity_of_a_sweep_without_noise_again) {
    std::mt19937_64 random(5);
    const auto panels = yard();
    const SurfaceMap map = map_of(panels, 0, random);
    const MotionState truth = driving();
    const auto sweep = sweep_of(panels, truth, 4000, random);
    WorkerPool workers(1);
    Vector12d off;
    off << 0.15, -0.1, 0.08, 0.01, -0.015, 0.02, 0.8, -0.5, 0.3, 0.05, 0.1, -0.1;
    const RegistrationSettings settings = to_the_end();
    const Registration found = register_sweep(map, sweep, state_near(truth, off, 1, 0.2), settings, workers);
    EXPECT_TRUE(found.converged);
    EXPECT_GT(found.fit, 0.8);
    const Vector12d left = difference(found.state, truth);
    EXPECT_LT(left.segment<3>(0).norm(), 0.001);
    EXPECT_LT(left.segment<3>(3).norm(), 0.01 * deg);
    EXPECT_LT(left.segment<3>(6).norm(), 0.03);
    EXPECT_LT(left.segment<3>(9).norm(), 0.3 * deg);
    EXPECT_EQ(found.degeneracy.free_directions, 0);
}

/// As where a vehicle sets off or swings round: it has accelerated since the sweep before.
TEST(Registration, undistorts_by_the_acceleration_since_the_sweep_before) {
    std::mt19937_64 random(8);
    const auto panels = yard();
    const SurfaceMap map = map_of(panels, 0, random);
    MotionState truth = driving();
    truth.velocity_before = {{7.2, 0.2, -0.1}, {0.05, -0.1, 0.3}};
    truth.duration_s = 0.1;
    const auto sweep = sweep_of(panels, truth, 4000, random);
    WorkerPool workers(1);
    const RegistrationSettings settings = to_the_end();
    MotionState predicted = predicted_near(truth);
    const Vector12d left = difference(register_sweep(map, sweep, predicted, settings, workers).state, truth);
    EXPECT_LT(left.segment<3>(0).norm(), 0.001);
    EXPECT_LT(left.segment<3>(3).norm(), 0.01 * deg);
    EXPECT_LT(left.segment<3>(9).norm(), 0.3 * deg);
    predicted.duration_s = 0;
    const Vector12d as_constant =
        difference(register_sweep(map, sweep, predicted, settings, workers).state, truth);
    EXPECT_GT(as_constant.segment<3>(3).norm(), 10 * left.segment<3>(3).norm());
}

/// As over bumps: nothing told it before.
TEST(Registration, undistorts_by_what_the_sweep_shows_of_its_acceleration_and_jerk) {
    std::mt19937_64 random(8);
    const auto panels = yard();
    const SurfaceMap map = map_of(panels, 0, random);
    MotionState truth = driving();
    truth.velocity_before = {{7.9, 0.2, -0.1}, {0.05, -0.1, 0.55}};
    truth.duration_s = 0.1;
    truth.acceleration_off = {{0.2, -0.3, 0.4}, {0.5, -0.6, 0.02}};
    truth.jerk = {{3, -5, 4}, {30, -25, 0.5}};
    const auto sweep = sweep_of(panels, truth, 4000, random);
    WorkerPool workers(1);
    MotionState predicted = predicted_near(truth);
    MotionNoise over_bumps;
    over_bumps.sigma_turn_radps2 = 3;
    expect_unevenness(predicted, over_bumps);
    const auto worst_turn_rad = [&] {
        const MotionState found = register_sweep(map, sweep, predicted, to_the_end(), workers).state;
        EXPECT_LT((found.T_map_base.translation_m - truth.T_map_base.translation_m).norm(), 0.001);
        double worst_rad = 0;
        for (const double s : {-0.05, -0.025, 0.0, 0.025, 0.05}) {
            const Pose3 beside = pose_near(truth, s).inverse() * pose_near(found, s);
            worst_rad = std::max(worst_rad, inertial::log_so3(beside.rotation).norm());
        }
        return worst_rad;
    };
    const double by_the_sweep_rad = worst_turn_rad();
    EXPECT_LT(by_the_sweep_rad, 0.02 * deg);
    predicted.sigma_acceleration_off.setZero();
    predicted.sigma_jerk.setZero();
    EXPECT_GT(worst_turn_rad(), 2 * by_the_sweep_rad);
}

/// After a jerk the prediction is far off: large cubes draw the sweep in, small ones then find its place.
TEST(Registration, large_cubes_draw_in_what_is_far_off) {
    std::mt19937_64 random(12);
    const auto panels = yard();
    const SurfaceMap map = map_of(panels, 0.01, random);
    WorkerPool workers(1);
    RegistrationSettings fine, coarse;
    fine.iterations = coarse.iterations = 20;
    coarse.smallest_size = 2;
    int alone = 0, drawn_in = 0;
    std::normal_distribution<double> normal;
    for (int run = 0; run < 20; ++run) {
        const MotionState truth = driving();
        const auto sweep = sweep_of(panels, truth, 3000, random);
        Vector12d off = Vector12d::Zero();
        off.segment<3>(0) << 0.8 * normal(random), 0.8 * normal(random), 0.05;
        off[5] = 0.1 * normal(random);
        const MotionState predicted = state_near(truth, off, 1, 0.2);
        const auto finds_it = [&](const MotionState* start) {
            const Registration found = register_sweep(map, sweep, predicted, fine, workers, start);
            return difference(found.state, truth).head<3>().norm() < 0.02;
        };
        const Registration from_afar = register_sweep(map, sweep, predicted, coarse, workers);
        alone += finds_it(nullptr) ? 1 : 0;
        drawn_in += finds_it(&from_afar.state) ? 1 : 0;
    }
    EXPECT_GE(drawn_in, 18);
    EXPECT_GT(drawn_in, alone);
}

TEST(Registration, tells_how_old_the_surfaces_are) {
    std::mt19937_64 random(9);
    const auto panels = yard();
    SurfaceMap map{SurfaceMapSettings{}};
    for (int sweep = 1; sweep <= 10; ++sweep) {
        map.begin_sweep();
        // Two sweeps made all that there is.
        if (sweep != 3 && sweep != 5) continue;
        for (int k = 0; k < 50000; ++k) {
            const Eigen::Vector3d p = place_on(any_of(panels, random), random);
            for (std::size_t size = 0; size < map.sizes(); ++size) map.add(size, {p, no_noise});
        }
    }
    const MotionState truth = driving();
    WorkerPool workers(1);
    const Registration found = register_sweep(map, sweep_of(panels, truth, 1000, random),
                                              state_near(truth, Vector12d::Zero(), 0.1, 0.02), {}, workers);
    // Most parts of cubes had their return from the first of them already.
    EXPECT_GT(found.age_sweeps, 6);
    EXPECT_LT(found.age_sweeps, 7);
}

/// Points all around that err each by itself, and in one direction with their neighbours.
TEST(SharedErrors, are_found_where_neighbours_err_together_and_nowhere_else) {
    std::mt19937_64 random(4);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0, 1);
    constexpr int points = 4000;
    for (const double shared : {0.0, 0.7}) {
        SweepMatrix alone = 1e-3 * SweepMatrix::Identity();
        double together = 0;
        SharedErrors errors;
        std::map<int, std::pair<double, double>> patches;  // error and Jacobian of each
        for (int k = 0; k < points; ++k) {
            const double azimuth_rad = 2 * M_PI * uniform(random),
                         range_m = std::pow(2.0, 1 + 5 * uniform(random)), s = 0.1 * (uniform(random) - 0.5);
            const int patch = 100 * static_cast<int>(azimuth_rad * 24 / (2 * M_PI)) +
                              static_cast<int>(std::clamp(std::floor(std::log2(range_m)), 2.0, 5.0));
            auto& [error, jacobian] = patches.try_emplace(patch, shared * normal(random), 0).first->second;
            Vector6d J;
            J[0] = 1;
            for (Eigen::Index axis = 1; axis < 6; ++axis) J[axis] = normal(random);
            const auto over_time = [s](const Vector6d& j) {
                return (SweepVector() << j, s * j, s * s / 2 * j, s * s * s / 6 * j).finished();
            };
            errors.add(range_m * Eigen::Vector3d(std::cos(azimuth_rad), std::sin(azimuth_rad), 0),
                       over_time(J * normal(random) + error * Vector6d::Unit(0)));
            alone += over_time(J) * over_time(J).transpose();
            ++jacobian;
        }
        for (const auto& [number, patch] : patches) together += std::pow(shared * patch.second, 2);
        const SweepMatrix found = errors.covariance(alone);
        const double expected = alone(0, 0) + together;
        EXPECT_NEAR(found(0, 0) / expected, 1, 0.35) << shared;
        for (Eigen::Index k = 1; k < 6; ++k) EXPECT_NEAR(found(k, k) / alone(k, k), 1, 0.35) << k;
        EXPECT_GE((found - alone).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(),
                  -1e-9 * alone.trace());
    }
}

TEST(Registration, does_not_depend_on_the_number_of_threads) {
    std::mt19937_64 random(6);
    const auto panels = yard();
    const SurfaceMap map = map_of(panels, 0.02, random);
    const auto sweep = sweep_of(panels, driving(), 2000, random);
    const MotionState start = state_near(driving(), 0.03 * Vector12d::Ones(), 0.2, 0.05);
    WorkerPool one(1), three(3);
    const Registration a = register_sweep(map, sweep, start, {}, one),
                       b = register_sweep(map, sweep, start, {}, three);
    EXPECT_EQ(a.state.T_map_base.translation_m, b.state.T_map_base.translation_m);
    EXPECT_EQ(a.state.T_map_base.rotation.coeffs(), b.state.T_map_base.rotation.coeffs());
    EXPECT_EQ(a.state.covariance, b.state.covariance);
}

TEST(Registration, tells_what_a_corridor_leaves_free_and_keeps_to_the_motion_there) {
    std::mt19937_64 random(7);
    const SurfaceMap map = map_of(corridor(45), 0.01, random);
    MotionState truth;
    truth.T_map_base.translation_m = {0, 0.3, 1};
    truth.velocity.shift_m = {5, 0, 0};
    const auto sweep = sweep_of(corridor(40), truth, 2000, random);
    Vector12d off = Vector12d::Zero();
    off.head<3>() << 0.3, 0.1, -0.05;
    WorkerPool workers(1);
    const Registration found = register_sweep(map, sweep, state_near(truth, off, 0.3, 0.05), {}, workers);
    EXPECT_EQ(found.degeneracy.free_directions, 1);
    EXPECT_GT(std::abs(found.degeneracy.weakest.normalized().x()), 0.99);
    const Vector12d left = difference(found.state, truth);
    EXPECT_NEAR(left[0], 0.3, 0.02);  // as predicted: nothing else is known
    EXPECT_NEAR(left[1], 0, 0.01);
    EXPECT_NEAR(left[2], 0, 0.01);
    EXPECT_GT(found.state.covariance(0, 0), 0.9 * 0.3 * 0.3);
    // What adds up from sweep to sweep: along the corridor what was predicted, to the side what was seen.
    EXPECT_GT(found.by_prediction(0, 0), 0.9 * found.state.covariance(0, 0));
    EXPECT_GT(found.by_scan(1, 1), 0.9 * found.state.covariance(1, 1));
    EXPECT_LT((found.by_scan + found.by_prediction - found.state.covariance.topLeftCorner<6, 6>())
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9);
    EXPECT_LT(found.state.covariance(1, 1), 0.01 * 0.01);
}

/// Somebody walks ahead in the corridor, or a plane has come about by chance: a few returns, which no others
/// could contradict. A wall at its end says more.
TEST(Registration, a_few_returns_alone_hold_no_direction) {
    std::mt19937_64 random(12);
    const Panel board{{6, -0.6, 0.4}, {0, 1.2, 0}, {0, 0, 1.4}};
    Panel moved = board;
    moved.corner_m.x() += 0.03;
    auto panels = corridor(45);
    panels.push_back(board);
    const SurfaceMap map = map_of(panels, 0.01, random);
    MotionState truth;
    truth.T_map_base.translation_m = {0, 0.3, 1};
    Vector12d off = Vector12d::Zero();
    off[0] = 0.06;
    WorkerPool workers(1);
    for (const int returns : {8, 100}) {
        auto sweep = sweep_of(corridor(40), truth, 2000, random);
        const auto ahead = sweep_of({moved}, truth, returns, random);
        sweep.insert(sweep.end(), ahead.begin(), ahead.end());
        const Registration found = register_sweep(map, sweep, state_near(truth, off, 0.3, 0.05), {}, workers);
        const double left_m = difference(found.state, truth)[0];
        const bool few = returns < 10;
        EXPECT_EQ(found.degeneracy.free_directions, few ? 1 : 0) << returns;
        EXPECT_NEAR(left_m, few ? 0.06 : -0.03, 0.01) << returns;
    }
}

/// Each sweep sees a little otherwise which way the corridor goes, and knows its walls to a millimetre: a
/// hundred of them must not tell how far it is along it.
TEST(Registration, a_hundred_sweeps_along_a_corridor_tell_nothing_of_the_way) {
    std::mt19937_64 random(10);
    const SurfaceMap map = map_of(corridor(60), 0.01, random);
    const MotionNoise noise;
    MotionState truth;
    truth.T_map_base.translation_m = {-30, 0.3, 1};
    truth.velocity.shift_m = {5, 0, 0};
    Vector12d off = Vector12d::Zero();
    off[0] = 0.1;
    MotionState state = state_near(truth, off, 0.1, 0.01), alone = state;
    WorkerPool workers(1);
    int free = 0;
    for (int sweep = 0; sweep < 100; ++sweep) {
        truth = predict(truth, 0.1, noise);
        alone = predict(alone, 0.1, noise);
        auto around = corridor(20);
        for (Panel& panel : around) panel.corner_m.x() += truth.T_map_base.translation_m.x();
        const Registration found = register_sweep(map, sweep_of(around, truth, 1000, random),
                                                  predict(state, 0.1, noise), {}, workers);
        state = found.state;
        free += found.degeneracy.free_directions;
        const Vector12d left = difference(state, truth);
        ASSERT_LT(left.segment<2>(1).norm(), 0.02) << sweep;
        ASSERT_LT(std::abs(left[0] - difference(alone, truth)[0]), 0.02) << sweep;
    }
    EXPECT_EQ(free, 100);
    EXPECT_GT(state.covariance(0, 0), 0.9 * alone.covariance(0, 0));
    EXPECT_GT(state.covariance(6, 6), 0.9 * alone.covariance(6, 6));
    EXPECT_LT(state.covariance(1, 1), 0.01 * 0.01);
}

/// Ground with hills of a few centimetres, a map of small pieces whose normals are as uncertain as the hills
/// are steep, and nothing else: the estimate must be about as good as it claims to be, and not be drawn to
/// where the prediction put it.
TEST(Registration, claims_no_more_than_it_knows_where_normals_are_uncertain) {
    std::mt19937_64 random(9);
    std::normal_distribution<double> normal;
    const auto height = [](double x, double y) {
        return 0.08 * std::sin(0.9 * x + 0.4 * y) + 0.08 * std::cos(0.7 * y - 0.5 * x);
    };
    std::uniform_real_distribution<double> across(-15, 15);
    WorkerPool workers(1);
    double chi2 = 0, error_m2 = 0;
    constexpr int runs = 20;
    for (int run = 0; run < runs; ++run) {
        SurfaceMapSettings settings;
        settings.sizes = 2;
        SurfaceMap map(settings);
        for (int k = 0; k < 40000; ++k) {
            const double x = across(random), y = across(random);
            for (std::size_t size = 0; size < 2; ++size)
                map.add(size, {{x, y, height(x, y) + 0.01 * normal(random)}, no_noise});
        }
        MotionState truth;
        truth.T_map_base.translation_m.z() = 1.5;
        std::vector<SweepPoint> sweep;
        for (int k = 0; k < 1500; ++k) {
            const double x = 0.8 * across(random), y = 0.8 * across(random);
            const Eigen::Vector3d p(x, y, height(x, y) + 0.01 * normal(random) - 1.5);
            sweep.push_back({p.cast<float>(), 0, p.normalized().cast<float>()});
        }
        Vector12d off = Vector12d::Zero();
        off.head<2>() << 0.1 * normal(random), 0.1 * normal(random);
        const Registration found = register_sweep(map, sweep, state_near(truth, off, 0.3, 0.03), {}, workers);
        const Eigen::Matrix<double, 6, 1> e = difference(found.state, truth).head<6>();
        chi2 += squared_in_sigmas(e, found.state.covariance.topLeftCorner<6, 6>()) / 6 / runs;
        error_m2 += e.head<2>().squaredNorm() / 2 / runs;
    }
    EXPECT_LT(std::sqrt(error_m2), 0.03);
    EXPECT_LT(chi2, 4);
}

}  // namespace
