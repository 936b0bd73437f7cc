/// A spinning lidar's path: surfaces of cubes, the motion of a sweep, and the pose by both.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <atomic>
#include <random>

#include "inertial/rotation_vector.h"
#include "lidar_mapping/registration.h"
#include "lidar_mapping/upright_walls.h"

using namespace loopline;
using namespace loopline::lidar_mapping;

namespace {

constexpr double deg = M_PI / 180;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// A rectangle in space: corner, and its two edges.
struct Panel {
    Eigen::Vector3d corner_m, edge_a_m, edge_b_m;
};

/// A yard 30 m x 20 m with walls, a floor and a slanting roof on one side.
std::vector<Panel> yard() {
    return {{{-15, -10, 0}, {30, 0, 0}, {0, 20, 0}}, {{-15, -10, 0}, {30, 0, 0}, {0, 0, 6}},
            {{-15, 10, 0}, {30, 0, 0}, {0, 0, 6}},   {{-15, -10, 0}, {0, 20, 0}, {0, 0, 6}},
            {{15, -10, 0}, {0, 20, 0}, {0, 0, 6}},   {{-15, 2, 6}, {20, 0, 0}, {0, 8, 3}},
            {{4, -3, 0}, {3, 1, 0}, {0, 0, 2.5}},    {{-8, 4, 0}, {1, -2, 0}, {0, 0, 2}}};
}

/// Floor and two walls, the same all along x.
std::vector<Panel> corridor(double half_m) {
    return {{{-half_m, -2, 0}, {2 * half_m, 0, 0}, {0, 4, 0}},
            {{-half_m, -2, 0}, {2 * half_m, 0, 0}, {0, 0, 3}},
            {{-half_m, 2, 0}, {2 * half_m, 0, 0}, {0, 0, 3}}};
}

/// Not on the border of two cubes.
const Eigen::Vector3d beside_m(0.13, 0.17, 0.11);

Eigen::Vector3d place_on(const Panel& panel, std::mt19937_64& random) {
    std::uniform_real_distribution<double> unit(0, 1);
    const double a = unit(random), b = unit(random);
    return beside_m + panel.corner_m + a * panel.edge_a_m + b * panel.edge_b_m;
}

const Panel& any_of(const std::vector<Panel>& panels, std::mt19937_64& random) {
    std::vector<double> areas_m2;
    for (const Panel& p : panels) areas_m2.push_back(p.edge_a_m.cross(p.edge_b_m).norm());
    std::discrete_distribution<std::size_t> by_area(areas_m2.begin(), areas_m2.end());
    return panels[by_area(random)];
}

/// A return as it is in a map that knows nothing of noise, seen straight from above.
MapReturn from_above(const Eigen::Vector3d& p_map_m) {
    return {p_map_m, {0, 0, -1}};
}
const Eigen::Matrix3f no_noise = Eigen::Matrix3f::Zero();

SurfaceMap map_of(const std::vector<Panel>& panels, double sigma_m, std::mt19937_64& random) {
    SurfaceMap map{SurfaceMapSettings{}};
    std::normal_distribution<double> normal;
    for (int k = 0; k < 100000; ++k) {
        const Panel& panel = any_of(panels, random);
        const Eigen::Vector3d n = panel.edge_a_m.cross(panel.edge_b_m).normalized();
        const Eigen::Vector3d p = place_on(panel, random) + sigma_m * normal(random) * n;
        for (std::size_t size = 0; size < map.sizes(); ++size) map.add(size, p, no_noise);
    }
    return map;
}

/// Points of a sweep of 0.1 s, each from where the vehicle is at its time.
std::vector<SweepPoint> sweep_of(const std::vector<Panel>& panels, const MotionState& truth, int points,
                                 std::mt19937_64& random) {
    std::vector<SweepPoint> sweep;
    for (int k = 0; k < points; ++k) {
        const double time_s = -0.05 + 0.1 * k / points;
        const Eigen::Vector3d p =
            pose_near(truth, time_s).inverse() * place_on(any_of(panels, random), random);
        sweep.push_back({p.cast<float>(), static_cast<float>(time_s), p.normalized().cast<float>()});
    }
    return sweep;
}

MotionState state_near(const MotionState& truth, const Vector12d& off, double sigma_m, double sigma_rad) {
    MotionState state = moved_by(truth, off);
    Vector12d sigma;
    sigma << Eigen::Vector3d::Constant(sigma_m), Eigen::Vector3d::Constant(sigma_rad),
        Eigen::Vector3d::Constant(10 * sigma_m), Eigen::Vector3d::Constant(10 * sigma_rad);
    state.covariance = sigma.cwiseAbs2().asDiagonal();
    return state;
}

MotionState driving() {
    MotionState truth;
    truth.T_map_base = {{1, -2, 1.5}, inertial::exp_so3({0.02, -0.03, 0.7})};
    truth.velocity = {{8, 0.2, -0.1}, {0.05, -0.1, 0.6}};
    return truth;
}

TEST(WorkerPool, runs_each_task_once) {
    for (const int threads : {1, 2, 5}) {
        WorkerPool workers(threads);
        for (int round = 0; round < 200; ++round) {
            std::vector<std::atomic<int>> runs(7);
            workers.run(runs.size(), [&](std::size_t k) { ++runs[k]; });
            for (const auto& count : runs) EXPECT_EQ(count, 1);
        }
    }
}

TEST(MotionState, prediction_has_the_covariance_of_samples) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    MotionState state = driving();
    Vector12d sigma;
    sigma << 0.1, 0.2, 0.1, 0.01, 0.02, 0.03, 0.5, 0.3, 0.2, 0.05, 0.02, 0.04;
    state.covariance = sigma.cwiseAbs2().asDiagonal();
    const MotionNoise noise{2, 0.5, 1, 0.3};
    const double duration_s = 0.3;
    const MotionState predicted = predict(state, duration_s, noise);
    Matrix12d sum = Matrix12d::Zero();
    constexpr int samples = 20000;
    for (int k = 0; k < samples; ++k) {
        Vector12d off;
        for (int i = 0; i < 12; ++i) off[i] = sigma[i] * normal(random);
        MotionState sample = moved_by(state, off);
        sample.T_map_base = sample.T_map_base * exp_se3(sample.velocity * duration_s);
        Vector12d pushed;
        for (int i = 0; i < 3; ++i) {
            const double a = noise.sigma_acceleration_mps2 * normal(random),
                         w = noise.sigma_turn_radps2 * normal(random);
            pushed[i] = a * duration_s * duration_s / 2;
            pushed[3 + i] = w * duration_s * duration_s / 2;
            pushed[6 + i] = a * duration_s;
            pushed[9 + i] = w * duration_s;
        }
        // Velocities are compared along the axes of the map before and after, which the turn moves little.
        const Vector12d d = difference(sample, predicted) + pushed;
        sum += d * d.transpose() / samples;
    }
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(std::sqrt(sum(i, i) / predicted.covariance(i, i)), 1, 0.05) << i;
    EXPECT_NEAR(sum(1, 5) / predicted.covariance(1, 5), 1, 0.15);
    EXPECT_NEAR(sum(0, 6) / predicted.covariance(0, 6), 1, 0.15);
}

TEST(MotionState, difference_undoes_a_step) {
    const MotionState state = driving();
    Vector12d step;
    step << 0.1, -0.2, 0.3, 0.4, 0.1, -0.2, 1, 2, -1, 0.3, 0.1, 0.2;
    EXPECT_LT((difference(moved_by(state, step), state) - step).norm(), 1e-12);
}

TEST(SurfaceMap, plane_of_a_cube_is_that_of_least_squares) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    int planes = 0;
    for (int run = 0; run < 200; ++run) {
        // In the cube 0 .. 0.5 m, one return for each of its parts.
        SurfaceMapSettings settings;
        settings.sizes = 1;
        SurfaceMap map(settings);
        const Eigen::Vector3d n = Eigen::Vector3d(normal(random), normal(random), normal(random))
                                      .normalized(),
                              a = n.unitOrthogonal(), b = n.cross(a), middle(0.25, 0.25, 0.25);
        std::vector<Eigen::Vector3d> counted;
        std::set<std::array<int, 3>> seen;
        std::uniform_real_distribution<double> across(-0.2, 0.2);
        for (int k = 0; k < 40; ++k) {
            const Eigen::Vector3d p =
                middle + across(random) * a + across(random) * b + 0.01 * normal(random) * n;
            if (p.minCoeff() < 0 || p.maxCoeff() >= 0.5) continue;
            map.add(0, p, no_noise);
            const std::array<int, 3> part = {static_cast<int>(p.x() * 8), static_cast<int>(p.y() * 8),
                                             static_cast<int>(p.z() * 8)};
            if (seen.insert(part).second) counted.push_back(p);
        }
        const SurfaceMatch match = map.find(from_above(middle));
        if (match.kind != SurfaceKind::plane) continue;
        ++planes;
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (const auto& p : counted) mean += p / static_cast<double>(counted.size());
        for (const auto& p : counted) covariance += (p - mean) * (p - mean).transpose();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
        const Eigen::Vector3d direction = match.direction_map.cast<double>();
        // A surface is fitted anew when it has an eighth more returns, so the last few may have no part.
        EXPECT_GT(std::abs(direction.dot(eigen.eigenvectors().col(0))), std::cos(4 * deg)) << run;
        EXPECT_LT(std::abs(direction.dot(match.offset_m.cast<double>() - (middle - mean))), 0.01);
    }
    EXPECT_GT(planes, 100);
}

TEST(SurfaceMap, what_is_seen_again_at_the_same_place_counts_once) {
    SurfaceMapSettings settings;
    settings.sizes = 1;
    settings.sigma_range_m = 0.01;
    SurfaceMap map(settings);
    // One ring across a cube, a hundred times: a line, which is no plane.
    for (int round = 0; round < 100; ++round)
        for (double y = 0.02; y < 0.5; y += 0.04) map.add(0, {0.1 + 0.001 * (round % 7), y, 0.2}, no_noise);
    EXPECT_EQ(map.find(from_above({0.1, 0.2, 0.2})).kind, SurfaceKind::none);
    // And what lies between the rings has its part still, when the lidar has moved on.
    for (double x = 0.02; x < 0.5; x += 0.06)
        for (double y = 0.02; y < 0.5; y += 0.06) map.add(0, {x, y, 0.2}, no_noise);
    const SurfaceMatch match = map.find(from_above({0.4, 0.4, 0.21}));
    ASSERT_EQ(match.kind, SurfaceKind::plane);
    EXPECT_GT(std::abs(match.direction_map.z()), 0.9999F);
    EXPECT_NEAR(std::abs(match.direction_map.dot(match.offset_m)), 0.01, 1e-3);
}

/// One ring of a lidar 1.8 m above the ground, 15 m away, seen again and again with noise of its ranges: the
/// noise spreads it along the beams, into a plane that contains them.
TEST(SurfaceMap, noise_of_ranges_makes_no_plane_of_a_ring) {
    std::mt19937_64 random(8);
    std::normal_distribution<double> normal;
    const double sigma_m = 0.05;
    int with = 0, without = 0;
    for (int run = 0; run < 50; ++run) {
        SurfaceMapSettings settings;
        settings.sigma_range_m = 0.01;
        SurfaceMap told(settings), untold(settings);
        const Eigen::Vector3d lidar(-15 + 0.01 * run, 0.25, 1.9);
        for (int k = 0; k < 400; ++k) {
            const double azimuth = 0.016 * (k % 20 - 9.5) / 10;
            Eigen::Vector3d beam(std::cos(azimuth), std::sin(azimuth), -1.8 / 15.25);
            beam.normalize();
            const double range_m = -1.8 / beam.z() + sigma_m * normal(random);
            const Eigen::Vector3d p = lidar + range_m * beam;
            const Eigen::Vector3f b = beam.cast<float>();
            const Eigen::Matrix3f noise = static_cast<float>(sigma_m * sigma_m) * b * b.transpose();
            for (std::size_t size = 0; size < told.sizes(); ++size) {
                told.add(size, p, noise);
                untold.add(size, p, no_noise);
            }
        }
        const Eigen::Vector3d place(0.25 + 0.01 * run, 0.25, 0.1);
        const MapReturn seen{place, (place - lidar).normalized().cast<float>()};
        with += told.find(seen).kind == SurfaceKind::plane ? 1 : 0;
        without += untold.find(seen).kind == SurfaceKind::plane ? 1 : 0;
    }
    EXPECT_LE(with, 2);
    EXPECT_GT(without, 20);
}

/// A map that leans, of walls, a floor and a roof; a car beside it leans otherwise.
TEST(UprightWalls, tell_which_way_is_up) {
    std::mt19937_64 random(21);
    std::normal_distribution<double> normal;
    auto panels = yard();
    panels.push_back({{-5, -4, 0}, {8, 0, 0}, {0, 0.35, 1.5}});  // its side, 13 degrees off
    const Eigen::Vector3d lean_rad(2 * deg, -1.2 * deg, 0);
    const Eigen::Quaterniond R_map_level = inertial::exp_so3(lean_rad);
    const auto map_of_part = [&](const std::vector<Panel>& seen, int points) {
        SurfaceMap map{SurfaceMapSettings{}};
        for (int k = 0; k < points; ++k) {
            const Panel& panel = any_of(seen, random);
            const Eigen::Vector3d n = panel.edge_a_m.cross(panel.edge_b_m).normalized();
            for (std::size_t size = 0; size < 2; ++size)
                map.add(size, R_map_level * (place_on(panel, random) + 0.02 * normal(random) * n), no_noise);
        }
        return map;
    };
    const auto off_rad = [&](const Upright& upright) -> Eigen::Vector2d {
        return (R_map_level.conjugate() * upright.up_map).head<2>();
    };
    const auto upright = upright_by_walls(map_of_part(panels, 300000));
    ASSERT_TRUE(upright.has_value());
    EXPECT_LT(off_rad(*upright).norm(), 0.3 * deg);
    EXPECT_LT(std::sqrt(upright->covariance_rad2.trace()), 0.4 * deg);

    // Walls along x alone: of the turn about y they tell nothing.
    const auto along_x = upright_by_walls(map_of_part({panels[0], panels[1], panels[2]}, 250000));
    ASSERT_TRUE(along_x.has_value());
    EXPECT_LT(std::abs(off_rad(*along_x).y()), 3 * std::sqrt(along_x->covariance_rad2(0, 0)));
    EXPECT_LT(std::sqrt(along_x->covariance_rad2(0, 0)), 0.4 * deg);
    EXPECT_GT(std::sqrt(along_x->covariance_rad2(1, 1)), 1.2 * deg);
    EXPECT_FALSE(upright_by_walls(map_of_part({panels[0]}, 20000)).has_value());
}

TEST(SurfaceMap, forgets_what_is_far_and_keeps_the_rest) {
    std::mt19937_64 random(4);
    SurfaceMapSettings settings;
    settings.keep_radius_m = 20;
    SurfaceMap map(settings);
    for (int k = 0; k < 200000; ++k) {
        std::uniform_real_distribution<double> x(-100, 100), y(-3, 3);
        const Eigen::Vector3d p(x(random), y(random), 0.1);
        for (std::size_t size = 0; size < map.sizes(); ++size) map.add(size, p, no_noise);
    }
    const std::size_t before = map.cells();
    ASSERT_EQ(map.find(from_above({50, 1, 0.1})).kind, SurfaceKind::plane);
    map.keep_around({-10, 0, 0});
    EXPECT_LT(map.cells(), before / 3);
    EXPECT_EQ(map.find(from_above({50, 1, 0.1})).kind, SurfaceKind::none);
    EXPECT_EQ(map.find(from_above({-25, 1, 0.1})).kind, SurfaceKind::plane);
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
    RegistrationSettings settings;
    settings.iterations = 50;
    settings.enough_m = 1e-6;
    settings.enough_rad = 1e-7;
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
    Vector12d off;
    off << 0.05, -0.04, 0.03, 0.01, -0.005, 0.01, 0.3, -0.2, 0.1, 0.03, 0.05, -0.05;
    RegistrationSettings settings;
    settings.iterations = 50;
    settings.enough_m = 1e-6;
    settings.enough_rad = 1e-7;
    MotionState predicted = state_near(truth, off, 1, 0.2);
    const Vector12d left = difference(register_sweep(map, sweep, predicted, settings, workers).state, truth);
    EXPECT_LT(left.segment<3>(0).norm(), 0.001);
    EXPECT_LT(left.segment<3>(3).norm(), 0.01 * deg);
    EXPECT_LT(left.segment<3>(9).norm(), 0.3 * deg);
    predicted.duration_s = 0;
    const Vector12d as_constant =
        difference(register_sweep(map, sweep, predicted, settings, workers).state, truth);
    EXPECT_GT(as_constant.segment<3>(3).norm(), 10 * left.segment<3>(3).norm());
}

TEST(SweepMotion, moves_with_the_velocity_as_differences_say) {
    MotionState state = driving();
    state.velocity_before = {{6, 0.3, 0}, {0, -0.2, 0.1}};
    state.duration_s = 0.08;
    for (const double s : {-0.05, -0.01, 0.03, 0.05}) {
        MotionState faster = state, slower = state;
        faster.velocity.shift_m.x() += 1e-3;
        slower.velocity.shift_m.x() -= 1e-3;
        const double difference_s =
            (SweepMotion(faster).after(s).shift_m.x() - SweepMotion(slower).after(s).shift_m.x()) / 2e-3;
        EXPECT_NEAR(SweepMotion(state).by_velocity_s(s), difference_s, 1e-9);
    }
    // Half of the way back it had the mean of both velocities.
    const double h = 1e-4, then_s = -state.duration_s / 2;
    const Twist3 rate =
        (SweepMotion(state).after(then_s + h) - SweepMotion(state).after(then_s - h)) * (0.5 / h);
    EXPECT_NEAR(rate.shift_m.x(), (state.velocity.shift_m.x() + state.velocity_before.shift_m.x()) / 2, 1e-6);
    EXPECT_NEAR(rate.turn_rad.z(), (state.velocity.turn_rad.z() + state.velocity_before.turn_rad.z()) / 2,
                1e-6);
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
            for (std::size_t size = 0; size < map.sizes(); ++size) map.add(size, p, no_noise);
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
                map.add(size, {x, y, height(x, y) + 0.01 * normal(random)}, no_noise);
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
        chi2 += e.dot(found.state.covariance.topLeftCorner<6, 6>().ldlt().solve(e)) / 6 / runs;
        error_m2 += e.head<2>().squaredNorm() / 2 / runs;
    }
    EXPECT_LT(std::sqrt(error_m2), 0.03);
    EXPECT_LT(chi2, 4);
}

}  // namespace
