/// What must not change the lines of a scan, and what changes them in a known way.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <random>

#include "property/lines_extracted.h"

using namespace loopline;
using namespace loopline::lines;
using namespace lines_world;

TEST(LineExtraction, turning_the_sensor_only_turns_alpha) {
    std::mt19937_64 random(33);
    std::uniform_real_distribution<double> angle(-M_PI, M_PI);
    for (const Method method : all_methods) {
        const auto extractor = extractor_of(method);
        for (int k = 0; k < 100; ++k) {
            World world;
            Sensor sensor;
            Sweep sweep = random_sweep(k, 0.01, random, world, sensor);
            const auto before = lines_of(*extractor, sweep.scan);
            const double turn = angle(random);
            sweep.scan.first_angle_rad += turn;
            const auto after = lines_of(*extractor, sweep.scan);
            ASSERT_EQ(before.size(), after.size());
            const Pose2 T{0, 0, turn};
            for (std::size_t i = 0; i < before.size(); ++i) {
                EXPECT_EQ(before[i].first_beam, after[i].first_beam);
                EXPECT_EQ(before[i].last_beam, after[i].last_beam);
                EXPECT_NEAR(before[i].rho_m, after[i].rho_m, 1e-12);
                EXPECT_NEAR(wrap_to_pi(before[i].alpha_rad + turn - after[i].alpha_rad), 0, 1e-12);
                EXPECT_LT((before[i].covariance - after[i].covariance).norm(), 1e-15);
                EXPECT_LT((T * before[i].start_m - after[i].start_m).norm(), 1e-11);
                EXPECT_LT((T * before[i].end_m - after[i].end_m).norm(), 1e-11);
            }
        }
    }
}

TEST(LineExtraction, shifting_world_and_sensor_together_changes_nothing) {
    std::mt19937_64 random(34);
    for (int k = 0; k < 50; ++k) {
        World world;
        Sensor sensor;
        Sweep here = random_sweep(k, 0, random, world, sensor);
        const Eigen::Vector2d shift(123, -45);
        for (auto& wall : world.walls) {
            wall.a_m += shift;
            wall.b_m += shift;
        }
        sensor.T_world_sensor.x_m += shift.x();
        sensor.T_world_sensor.y_m += shift.y();
        Sweep there = lines_world::sweep(world, sensor);
        here.scan.sigma_range_m = there.scan.sigma_range_m = 0.01;
        const auto extractor = extractor_of(all_methods[k % 3]);
        const auto a = lines_of(*extractor, here.scan), b = lines_of(*extractor, there.scan);
        ASSERT_EQ(a.size(), b.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            EXPECT_NEAR(a[i].rho_m, b[i].rho_m, 1e-5);
            EXPECT_NEAR(wrap_to_pi(a[i].alpha_rad - b[i].alpha_rad), 0, 1e-5);
        }
    }
}

TEST(LineExtraction, the_mirrored_world_has_the_mirrored_lines) {
    std::mt19937_64 random(35);
    for (const Method method : all_methods) {
        const auto extractor = extractor_of(method);
        int all = 0, matched = 0;
        for (int k = 0; k < 150; ++k) {
            World world;
            Sensor sensor;
            Sweep sweep = random_sweep(k, 0.01, random, world, sensor);
            const auto before = lines_of(*extractor, sweep.scan);
            std::reverse(sweep.scan.ranges_m.begin(), sweep.scan.ranges_m.end());
            auto after = lines_of(*extractor, sweep.scan);
            for (auto& s : after) {
                s.alpha_rad = wrap_to_pi(-s.alpha_rad);
                std::swap(s.start_m, s.end_m);
                s.start_m.y() *= -1;
                s.end_m.y() *= -1;
            }
            for (const auto& s : before) {
                ++all;
                if (nearest_in_sigmas(s, after) < 1) ++matched;
            }
        }
        SCOPED_TRACE(static_cast<int>(method));
        EXPECT_GT(matched, (method == Method::incremental ? 0.9 : 0.96) * all);
    }
}

TEST(LineExtraction, a_clockwise_sensor_sees_the_same_lines) {
    std::mt19937_64 random(36);
    World world;
    Sensor sensor;
    Sweep sweep = random_sweep(3, 0.01, random, world, sensor);
    LineSegments results[2];
    for (const bool clockwise : {false, true}) {
        auto ranges = sweep.scan.ranges_m;
        if (clockwise) std::reverse(ranges.begin(), ranges.end());
        mrpt::obs::CObservation2DRangeScan observation;
        observation.aperture = static_cast<float>(M_PI);
        observation.maxRange = 80;
        observation.rightToLeft = !clockwise;
        const std::vector<char> valid(ranges.size(), 1);
        observation.loadFromVectors(ranges.size(), ranges.data(), valid.data());
        PlanarScan scan;
        ASSERT_TRUE(to_planar_scan(observation, scan));
        results[clockwise] = lines_of(*extractor_of(Method::angle_threshold), scan);
    }
    ASSERT_GT(results[0].size(), 1u);
    ASSERT_EQ(results[0].size(), results[1].size());
    for (std::size_t i = 0; i < results[0].size(); ++i) EXPECT_EQ(results[0][i].rho_m, results[1][i].rho_m);
}

TEST(LineExtraction, four_times_the_beams_a_quarter_of_the_variance) {
    World world;
    world.walls.push_back({{3, -2}, {3, 4}});
    for (const Method method : all_methods) {
        const auto extractor = extractor_of(method);
        Eigen::Matrix2d few = Eigen::Matrix2d::Zero(), many = few;
        for (const std::size_t beams : {181u, 721u}) {
            Sensor sensor;
            sensor.beams = beams;
            Sweep sweep = lines_world::sweep(world, sensor);
            sweep.scan.sigma_range_m = 0.01;
            const auto segments = lines_of(*extractor, sweep.scan);
            ASSERT_EQ(segments.size(), 1u);
            (beams == 181 ? few : many) = segments[0].covariance;
        }
        EXPECT_LT((few - 4 * many).norm(), 0.05 * few.norm());
    }
}

TEST(LineExtraction, depends_on_the_scan_alone) {
    std::mt19937_64 random(37);
    for (const Method method : all_methods) {
        const auto used = extractor_of(method);
        for (int k = 0; k < 40; ++k) {
            World world;
            Sensor sensor;
            const Sweep sweep = random_sweep(k, 0.02, random, world, sensor);
            const auto a = lines_of(*used, sweep.scan), b = lines_of(*extractor_of(method), sweep.scan);
            ASSERT_EQ(a.size(), b.size());
            for (std::size_t i = 0; i < a.size(); ++i) {
                EXPECT_EQ(a[i].rho_m, b[i].rho_m);
                EXPECT_EQ(a[i].alpha_rad, b[i].alpha_rad);
                EXPECT_EQ(a[i].covariance, b[i].covariance);
            }
        }
    }
}
