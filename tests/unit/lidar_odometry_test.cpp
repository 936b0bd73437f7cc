/// Odometry of a spinning lidar: features, correspondences, the motion between two sweeps, and the path.
#include <gtest/gtest.h>

#include <random>

#include "api/dense_algebra.h"
#include "inertial/rotation_vector.h"
#include "lidar_odometry/sweep_odometry.h"
#include "support/spinning_world.h"

using namespace loopline;
using namespace loopline::lidar_odometry;
using test::endless_corridor;
using test::SpinningBeams;
using test::sweep_in;
using test::walled_yard;

namespace {

const Pose3 start_pose({-12, -1, 1.8}, inertial::exp_so3({0.01, -0.02, 0.1}));

/// Two sweeps of a lidar at the vehicle's origin that moves at a constant velocity.
struct TwoSweeps {
    TwoSweeps(const std::vector<test::Rectangle>& world, const Twist3& velocity, const SpinningBeams& beams,
              std::uint64_t seed, double sigma_surface_m = FeatureSettings().sigma_surface_m) {
        std::mt19937_64 random(seed);
        FeatureSettings settings;
        settings.sigma_surface_m = sigma_surface_m;
        FeatureFinder finder;
        SweepFeatures features;
        const auto sweep = [&](double at_s) {
            const auto T = [&](double time_s) { return start_pose * exp_se3(velocity * (at_s + time_s)); };
            finder.find(sweep_in(world, T, 0, beams, random), settings, features);
        };
        sweep(0);
        before.set(features, velocity);
        sweep(0.1);
        now = features;
        T_before_now = exp_se3(velocity * 0.1);
    }

    MatchedMotion match(const Pose3& expected, int threads = 1) const {
        ExpectedMotion motion;
        motion.T_before_now = expected;
        motion.covariance.diagonal() << Eigen::Vector3d::Constant(0.01), Eigen::Vector3d::Constant(1e-3);
        WorkerPool workers(threads);
        return match_sweeps(before, now, motion, MatchingSettings{}, workers);
    }

    ReferenceSweep before;
    SweepFeatures now;
    Pose3 T_before_now;
};

Vector6d off_by(const Pose3& found, const Pose3& truth) {
    const Twist3 off = log_se3(found * truth.inverse());
    Vector6d v;
    v << off.shift_m, off.turn_rad;
    return v;
}

const Twist3 round_a_bend{{8, 0.2, -0.1}, {0.05, -0.1, 0.5}};

Eigen::Vector3d random_vector(std::mt19937_64& random, double size) {
    std::uniform_real_distribution<double> unit(-1, 1);
    return size * Eigen::Vector3d(unit(random), unit(random), unit(random));
}

/// How far a point lies from a rectangle, and from the nearest of its four borders.
std::pair<double, double> distances(const test::Rectangle& r, const Eigen::Vector3d& p_m) {
    const Eigen::Vector3d n = r.edge_a_m.cross(r.edge_b_m).normalized(), at_m = p_m - r.corner_m;
    const double a = at_m.dot(r.edge_a_m.normalized()), b = at_m.dot(r.edge_b_m.normalized());
    const auto outside = [](double x, double length) { return std::max({0.0, -x, x - length}); };
    const double la = r.edge_a_m.norm(), lb = r.edge_b_m.norm();
    const double over = std::hypot(n.dot(at_m), std::hypot(outside(a, la), outside(b, lb)));
    const double inside = std::min({std::abs(a), std::abs(a - la), std::abs(b), std::abs(b - lb)});
    return {over, std::hypot(n.dot(at_m), inside)};
}

TEST(LidarFeatures, edge_points_lie_on_borders_and_planar_points_on_surfaces) {
    std::mt19937_64 random(1);
    const auto world = walled_yard();
    const Pose3 standing({-12, -1, 1.8}, Eigen::Quaterniond::Identity());
    FeatureFinder finder;
    SweepFeatures features;
    finder.find(sweep_in(
                    world, [&](double) { return standing; }, 0, {}, random),
                {}, features);
    ASSERT_GT(features.edges.size(), 100u);
    ASSERT_GT(features.planar.size(), 1000u);
    for (const Feature& planar : features.planar) {
        double nearest_m = 1e9;
        for (const auto& r : world)
            nearest_m = std::min(
                nearest_m, distances(r, standing * Eigen::Vector3d(planar.p_base_m.cast<double>())).first);
        EXPECT_LT(nearest_m, 0.03);
        EXPECT_NEAR(planar.along_base.norm(), 1, 1e-5);
    }
    for (const Feature& edge : features.edges) {
        double nearest_m = 1e9;
        for (const auto& r : world)
            nearest_m = std::min(
                nearest_m, distances(r, standing * Eigen::Vector3d(edge.p_base_m.cast<double>())).second);
        // Half of the way between two returns, which lie the farther apart the more slanting the wall.
        EXPECT_LT(nearest_m, 0.05 + 4 * std::sqrt(edge.variance_m2)) << edge.p_base_m.transpose();
    }
}

TEST(LidarFeatures, nothing_outside_of_the_range_gate_counts) {
    std::mt19937_64 random(2);
    FeatureSettings settings;
    settings.min_range_m = 6;
    settings.max_range_m = 15;
    FeatureFinder finder;
    SweepFeatures features;
    finder.find(sweep_in(
                    walled_yard(), [&](double) { return start_pose; }, 0, {}, random),
                settings, features);
    ASSERT_GT(features.planar.size(), 100u);
    for (const auto* list : {&features.edges, &features.planar})
        for (const Feature& feature : *list) {
            EXPECT_GT(feature.p_base_m.norm(), 5.9f);
            EXPECT_LT(feature.p_base_m.norm(), 15.1f);
        }
}

/// A pillar before a wall: its own borders are edges, those of its shadow on the wall are none.
TEST(LidarFeatures, the_border_of_a_shadow_is_no_edge) {
    std::mt19937_64 random(3);
    std::vector<test::Rectangle> world{{{-30, 10, -5}, {60, 0, 0}, {0, 0, 20}}};
    world.push_back({{-0.3, 5, -5}, {0.6, 0, 0}, {0, 0, 20}});
    FeatureFinder finder;
    SweepFeatures features;
    finder.find(sweep_in(
                    world, [](double) { return Pose3(); }, 0, {}, random),
                {}, features);
    int on_pillar = 0;
    for (const Feature& edge : features.edges) {
        if (std::abs(edge.p_base_m.x()) > 5) continue;  // where the wall ends in the distance
        EXPECT_NEAR(edge.p_base_m.y(), 5, 0.1);
        EXPECT_NEAR(std::abs(edge.p_base_m.x()), 0.3, 0.03);
        ++on_pillar;
    }
    EXPECT_GE(on_pillar, 2 * 20);
}

TEST(KdTree, finds_what_looking_at_all_points_finds) {
    std::mt19937_64 random(4);
    for (const std::size_t count : {0U, 1U, 7U, 300U, 5000U}) {
        std::vector<Eigen::Vector3f> points;
        // On a coarse grid, so that some points are the same and many are equally far.
        for (std::size_t i = 0; i < count; ++i) {
            Eigen::Vector3f p = random_vector(random, 20).cast<float>();
            if (i % 2 == 0) p = p.array().round();
            points.push_back(p);
        }
        KdTree tree;
        tree.build(points);
        for (int k = 0; k < 300; ++k) {
            Eigen::Vector3f q = random_vector(random, 25).cast<float>();
            if (k % 3 == 0) q = q.array().round();
            const float limit_m = k % 5 == 0 ? 2.f : 100.f;
            const auto wanted = [k](std::uint32_t i) { return k % 2 == 0 || i % 3 == 1; };
            std::uint32_t best = KdTree::none;
            float best_m2 = limit_m * limit_m;
            for (std::uint32_t i = 0; i < count; ++i) {
                const float m2 = (points[i] - q).squaredNorm();
                if (wanted(i) && m2 < best_m2) {
                    best_m2 = m2;
                    best = i;
                }
            }
            EXPECT_EQ(tree.nearest(q, limit_m, wanted), best);
        }
    }
}

/// The nearest of a list by looking at all.
template <class Accept>
std::uint32_t nearest_of(const std::vector<Feature>& features, const Eigen::Vector3d& p_m, double limit_m,
                         const Accept& accept) {
    std::uint32_t best = KdTree::none;
    const Eigen::Vector3f q = p_m.cast<float>();
    float best_m2 = static_cast<float>(limit_m) * static_cast<float>(limit_m);
    for (std::uint32_t i = 0; i < features.size(); ++i) {
        const float m2 = (features[i].p_base_m - q).squaredNorm();
        if (accept(features[i], i) && m2 < best_m2) {
            best_m2 = m2;
            best = i;
        }
    }
    return best;
}

TEST(LidarCorrespondences, are_those_of_looking_at_all_points) {
    const TwoSweeps sweeps(walled_yard(), round_a_bend, {16, 600, 0.15, -0.3, 0.1, 0.02}, 5);
    const CorrespondenceSettings settings;
    const auto& edges = sweeps.before.edges;
    const auto& planar = sweeps.before.planar;
    int lines = 0, planes = 0;
    for (std::size_t k = 0; k < 300; ++k) {
        const Eigen::Vector3d p_m =
            sweeps.T_before_now *
            Eigen::Vector3d(sweeps.now.edges[k % sweeps.now.edges.size()].p_base_m.cast<double>());
        const auto line = find_line(sweeps.before, p_m, settings);
        if (!line) continue;
        ++lines;
        const std::uint32_t j = nearest_of(edges, p_m, settings.max_distance_m,
                                           [](const Feature&, std::uint32_t) { return true; });
        const std::uint32_t l =
            nearest_of(edges, p_m, settings.max_distance_m, [&](const Feature& f, std::uint32_t) {
                return f.ring != edges[j].ring && std::abs(f.ring - edges[j].ring) <= settings.max_ring_gap;
            });
        EXPECT_EQ(line->nearest, j);
        EXPECT_EQ(line->other, l);
        EXPECT_NE(edges[line->nearest].ring, edges[line->other].ring);
        for (const std::uint32_t i : {j, l}) {
            const Eigen::Vector3d off = edges[i].p_base_m.cast<double>() - line->point_m;
            EXPECT_LT(off.cross(line->direction).norm(), 1e-5);
        }
    }
    for (std::size_t k = 0; k < 600; ++k) {
        const Feature& point = sweeps.now.planar[(7 * k) % sweeps.now.planar.size()];
        const Eigen::Vector3d p_m = sweeps.T_before_now * Eigen::Vector3d(point.p_base_m.cast<double>());
        const auto plane = find_plane(
            sweeps.before, p_m, sweeps.T_before_now.rotation * point.along_base.cast<double>(), settings);
        if (!plane) continue;
        ++planes;
        const std::uint32_t j = nearest_of(planar, p_m, settings.max_distance_m,
                                           [](const Feature&, std::uint32_t) { return true; });
        const std::uint32_t l =
            nearest_of(planar, p_m, settings.max_distance_m,
                       [&](const Feature& f, std::uint32_t i) { return i != j && f.ring == planar[j].ring; });
        const std::uint32_t m = nearest_of(
            planar, p_m, settings.max_distance_m,
            [&](const Feature& f, std::uint32_t) { return std::abs(f.ring - planar[j].ring) == 1; });
        EXPECT_EQ(plane->nearest, j);
        EXPECT_EQ(plane->same_ring, l);
        EXPECT_EQ(plane->other_ring, m);
        EXPECT_NEAR(plane->normal.norm(), 1, 1e-12);
        for (const std::uint32_t i : {j, l, m})
            EXPECT_NEAR(plane->normal.dot(planar[i].p_base_m.cast<double>() - plane->point_m), 0, 1e-5);
    }
    EXPECT_GT(lines, 100);
    EXPECT_GT(planes, 200);
}

/// Two of a ring on a road, the third on a kerb beside it; the road goes on at the other side.
TEST(LidarCorrespondences, no_plane_leads_over_a_step) {
    const auto feature = [](double x_m, double y_m, double z_m, int ring) {
        Feature f;
        f.p_base_m = Eigen::Vector3d(x_m, y_m, z_m).cast<float>();
        f.along_base = {1, 0, 0};
        f.roughness_m2 = 1e-4f;
        f.ring = static_cast<std::uint16_t>(ring);
        return f;
    };
    for (const double kerb_m : {0.0, 0.15}) {
        ReferenceSweep before;
        SweepFeatures features;
        features.planar = {feature(0.1, 1, kerb_m, 4), feature(0, 0, 0, 5), feature(0.3, 0, 0, 5),
                           feature(0.1, -1, 0, 6)};
        before.set(features, {});
        EXPECT_EQ(find_plane(before, {0.1, 0.4, 0}, {1, 0, 0}, {}).has_value(), kerb_m == 0);
    }
}

TEST(LidarResiduals, have_the_jacobians_of_central_differences) {
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> time(-0.05, 0.05);
    for (int k = 0; k < 200; ++k) {
        const Pose3 T(random_vector(random, 2), inertial::exp_so3(random_vector(random, 0.1)));
        const Eigen::Vector3d p_m = random_vector(random, 30);
        const double time_s = time(random);
        PlaneOfPoints plane;
        plane.normal = random_vector(random, 1).normalized();
        plane.point_m = random_vector(random, 30);
        LineOfEdges line;
        line.direction = random_vector(random, 1).normalized();
        line.point_m = random_vector(random, 30);
        const auto of_line = to_line(line);
        for (const Residual& residual : {to_plane(plane), of_line[0], of_line[1]}) {
            const auto value = [&](const Vector6d& step) {
                const Pose3 moved = exp_se3({step.head<3>(), step.tail<3>()}) * T;
                return residual.of(ConstantTwist(moved, 0.1).at(time_s) * p_m);
            };
            const ConstantTwist motion(T, 0.1);
            const Row6d j = residual.jacobian(motion.at(time_s) * p_m, time_s, motion);
            for (int i = 0; i < 6; ++i) {
                const Vector6d step = 1e-5 * Vector6d::Unit(i);
                EXPECT_NEAR(j[i], (value(step) - value(-step)) / 2e-5, 2e-4 * (1 + std::abs(j[i])));
            }
        }
        // The two residuals of a line are the distance from it.
        const Eigen::Vector3d off = p_m - line.point_m;
        EXPECT_NEAR(std::hypot(of_line[0].of(p_m), of_line[1].of(p_m)), off.cross(line.direction).norm(),
                    1e-9);
    }
}

TEST(LidarOdometry, recovers_a_motion_without_noise_to_a_millimetre) {
    for (const Twist3& velocity :
         {round_a_bend, Twist3{{-3, 0, 0}, {0, 0, -0.8}}, Twist3{{0, 0, 0}, {0, 0, 0}}}) {
        const TwoSweeps sweeps(walled_yard(), velocity, {}, 7);
        const Pose3 expected = exp_se3({{0.1, -0.03, 0.02}, {0.002, -0.004, 0.01}}) * sweeps.T_before_now;
        const MatchedMotion found = sweeps.match(expected);
        EXPECT_TRUE(found.converged);
        EXPECT_EQ(found.free.count, 0);
        const Vector6d off = off_by(found.T_before_now, sweeps.T_before_now);
        EXPECT_LT(off.head<3>().norm(), 1e-3) << off.transpose();
        EXPECT_LT(off.tail<3>().norm(), 0.01 * M_PI / 180) << off.transpose();
    }
}

TEST(LidarOdometry, gives_the_same_bits_for_any_number_of_threads) {
    const TwoSweeps sweeps(walled_yard(), round_a_bend, {16, 600, 0.15, -0.3, 0.1, 0.02}, 8);
    const MatchedMotion a = sweeps.match(Pose3(), 1), b = sweeps.match(Pose3(), 3);
    EXPECT_EQ(a.T_before_now.translation_m, b.T_before_now.translation_m);
    EXPECT_EQ(a.T_before_now.rotation.coeffs(), b.T_before_now.rotation.coeffs());
    EXPECT_EQ(a.covariance, b.covariance);
}

TEST(LidarOdometry, tells_what_a_corridor_leaves_free_and_keeps_to_what_was_expected_there) {
    const TwoSweeps sweeps(endless_corridor(), {{6, 0, 0}, {0, 0, 0.05}}, {32, 900, 0.18, -0.5, 0.1, 0.02},
                           9);
    const Pose3 expected = exp_se3({{0.06, 0.02, -0.02}, {0, 0, 0.004}}) * sweeps.T_before_now;
    const MatchedMotion found = sweeps.match(expected);
    EXPECT_EQ(found.free.count, 1);
    EXPECT_GT(std::abs(found.free.weakest_moves_m[0]), 0.98) << found.free.weakest_moves_m.transpose();
    const Vector6d off = off_by(found.T_before_now, sweeps.T_before_now);
    EXPECT_NEAR(off[0], 0.06, 0.015);
    EXPECT_LT(off.segment<2>(1).norm(), 0.01);
    EXPECT_NEAR(std::sqrt(found.covariance(0, 0)), 0.1, 0.02);  // as was expected: nothing else is known
    EXPECT_LT(std::sqrt(found.covariance(1, 1)), 0.01);
}

TEST(LidarOdometry, its_covariance_is_that_of_many_runs) {
    double nees = 0;
    constexpr int runs = 40;
    Vector6d squares = Vector6d::Zero(), variances = Vector6d::Zero();
    for (int k = 0; k < runs; ++k) {
        const TwoSweeps sweeps(walled_yard(), round_a_bend, {16, 600, 0.15, -0.3, 0.1, 0.02},
                               100 + static_cast<std::uint64_t>(k), 1e-4);
        const MatchedMotion found = sweeps.match(sweeps.T_before_now);
        const Vector6d off = off_by(found.T_before_now, sweeps.T_before_now);
        nees += squared_in_sigmas(off, found.covariance) / runs;
        squares += off.cwiseAbs2() / runs;
        variances += found.covariance.diagonal() / runs;
    }
    EXPECT_GT(nees, 1.5);
    EXPECT_LT(nees, 12);
    for (int i = 0; i < 6; ++i) {
        const double ratio = std::sqrt(squares[i] / variances[i]);
        EXPECT_GT(ratio, 0.4) << i;
        EXPECT_LT(ratio, 2) << i;
    }
}

/// On the move from the start, and braking.
TEST(LidarOdometry, finds_the_speed_at_the_start_and_follows) {
    std::mt19937_64 random(10);
    const auto world = walled_yard();
    const auto T_at = [](double t_s) {
        const double way_m = 11 * t_s - t_s * t_s;  // 11 m/s, 2 m/s2 less each second
        return Pose3({-20 + way_m, -1, 1.8}, Eigen::Quaterniond::Identity());
    };
    SweepOdometry odometry({}, 1);
    for (int k = 0; k < 12; ++k) {
        const double at_s = 0.1 * k;
        const auto T = [&](double time_s) { return T_at(at_s + time_s); };
        EXPECT_TRUE(
            odometry.add(sweep_in(world, T, 100000000LL * k, {16, 600, 0.15, -0.3, 0.1, 0.02}, random)));
    }
    const OdometryStep& step = odometry.latest();
    const Pose3 truth = T_at(0).inverse() * T_at(1.1);
    EXPECT_LT((step.T_map_base.translation_m - truth.translation_m).norm(), 0.02);
    EXPECT_NEAR(step.velocity.shift_m.x(), 11 - 2 * 1.05, 0.1);
    EXPECT_NEAR(step.T_map_base.rotation.norm(), 1, 1e-12);
    EXPECT_GT(step.covariance(0, 0), 11 * 1e-8);
    // A sweep that is no later changes nothing.
    EXPECT_FALSE(odometry.add(sweep_in(world, T_at, 100000000LL * 11, {16, 600}, random)));
    EXPECT_EQ(odometry.latest().T_map_base.translation_m, step.T_map_base.translation_m);
}

}  // namespace
