/// Line extraction on random polygon worlds against truth, and on what holds no lines.
#include <gtest/gtest.h>

#include <random>

#include "property/lines_extracted.h"
#include "property/lines_truth.h"

using namespace loopline;
using namespace loopline::lines;
using namespace lines_world;

TEST(LineExtraction, without_noise_every_wall_is_found_exactly) {
    for (const Method method : all_methods) {
        std::mt19937_64 random(31);
        const auto extractor = extractor_of(method);
        Score score;
        std::size_t exact = 0, all = 0;
        for (int k = 0; k < 200; ++k) {
            World world;
            Sensor sensor;
            Sweep sweep = random_sweep(k, 0, random, world, sensor);
            sweep.scan.sigma_range_m = 0.001;
            const auto segments = lines_of(*extractor, sweep.scan);
            score.add(world, sensor.T_world_sensor, sweep, segments);
            for (const auto& s : segments) {
                ++all;
                for (const auto& wall : world.walls) {
                    const auto truth = lines_world::true_line(wall, sensor.T_world_sensor);
                    // Ranges are single precision: 6e-8 of them.
                    if (std::abs(s.rho_m - truth.rho_m) < 2e-6 &&
                        std::abs(wrap_to_pi(s.alpha_rad - truth.alpha_rad)) < 2e-6) {
                        ++exact;
                        break;
                    }
                }
            }
        }
        SCOPED_TRACE(static_cast<int>(method));
        EXPECT_GT(score.recall(), 0.97);
        // A line may hold a beam of the next wall within a sigma of it; most must not.
        EXPECT_GT(static_cast<double>(exact),
                  (method == Method::incremental ? 0.8 : 0.95) * static_cast<double>(all));
    }
}

TEST(LineExtraction, with_noise_walls_are_found_and_the_covariance_is_honest) {
    for (const Method method : all_methods) {
        for (const double sigma_m : {0.01, 0.03}) {
            std::mt19937_64 random(32);
            const auto extractor = extractor_of(method);
            Score score;
            for (int k = 0; k < 300; ++k) {
                World world;
                Sensor sensor;
                const Sweep sweep = random_sweep(k, sigma_m, random, world, sensor);
                score.add(world, sensor.T_world_sensor, sweep, lines_of(*extractor, sweep.scan));
            }
            SCOPED_TRACE(testing::Message()
                         << "method " << static_cast<int>(method) << ", sigma " << sigma_m);
            EXPECT_GT(score.recall(), sigma_m < 0.02 ? 0.96 : method == Method::incremental ? 0.9 : 0.93);
            EXPECT_LT(score.false_lines, 300 * 0.08) << "walls that meet almost straight, mostly";
            EXPECT_GT(score.nees_mean(), 1.5) << "two degrees of freedom";
            EXPECT_LT(score.nees_mean(), method == Method::incremental ? 3.2 : 2.6);
        }
    }
}

TEST(LineExtraction, in_a_full_circle_the_wall_over_the_seam_is_one_line) {
    World room;
    const Eigen::Vector2d corners[4] = {{4, 3}, {-4, 3}, {-4, -3}, {4, -3}};
    for (int i = 0; i < 4; ++i) room.walls.push_back({corners[i], corners[(i + 1) % 4]});
    for (const Method method : all_methods) {
        const auto extractor = extractor_of(method);
        for (int k = 0; k < 60; ++k) {
            Sensor sensor;
            sensor.beams = 720;
            sensor.aperture_rad = 2 * M_PI * 719 / 720;
            sensor.T_world_sensor = {0.3, 0.4, 0.1 * k};
            std::mt19937_64 random(38 + static_cast<std::uint64_t>(k));
            Sweep sweep = lines_world::sweep(room, sensor);
            lines_world::add_range_noise(sweep, 0.01, random);
            const auto segments = lines_of(*extractor, sweep.scan);
            ASSERT_EQ(segments.size(), 4u) << "method " << static_cast<int>(method) << ", view " << k;
            std::size_t over_the_seam = 0;
            for (const auto& s : segments) {
                if (s.first_beam > s.last_beam) ++over_the_seam;
                EXPECT_GT(s.length_m(), 5.4)
                    << "what is left of a wall beyond the seam may be too short for a line";
                EXPECT_LT(s.length_m(), 8.1);
                // Counter-clockwise from start to end.
                EXPECT_GT(s.start_m.x() * s.end_m.y() - s.start_m.y() * s.end_m.x(), 0);
            }
            EXPECT_LE(over_the_seam, 1u);
        }
    }
}

TEST(LineExtraction, round_rooms_and_pillars_hold_no_lines) {
    for (const Method method : {Method::angle_threshold, Method::split_and_merge}) {
        const auto extractor = extractor_of(method);
        std::mt19937_64 random(39);
        std::uniform_real_distribution<double> unit(0, 1);
        int lines = 0, scans = 0;
        for (int k = 0; k < 300; ++k) {
            World world;
            const double radius_m = 0.1 + 5 * unit(random);
            const bool room = k % 2 == 0;
            world.circles.push_back(
                {{room ? 0.3 * radius_m : radius_m + 0.5 + 3 * unit(random), 0.1}, radius_m});
            Sensor sensor;
            sensor.beams = k % 3 ? 181 : 541;
            Sweep sweep = lines_world::sweep(world, sensor);
            lines_world::add_range_noise(sweep, 0.01, random);
            lines += static_cast<int>(lines_of(*extractor, sweep.scan).size());
            ++scans;
        }
        SCOPED_TRACE(static_cast<int>(method));
        EXPECT_LT(lines, 0.05 * scans);
    }
}

TEST(LineExtraction, clutter_holds_no_lines) {
    std::mt19937_64 random(40);
    std::uniform_real_distribution<float> range(0.5, 6);
    std::normal_distribution<float> leaf(0, 0.4f);
    for (const Method method : all_methods) {
        const auto extractor = extractor_of(method);
        int lines = 0;
        for (int k = 0; k < 200; ++k) {
            PlanarScan scan = uniform_scan(361, M_PI, 0);
            scan.sigma_range_m = 0.01;
            for (std::size_t i = 0; i < scan.size(); ++i)
                scan.ranges_m[i] =
                    k % 2 ? range(random) : std::max(0.3f, 4 + leaf(random));  // hail, or a hedge
            lines += static_cast<int>(lines_of(*extractor, scan).size());
        }
        SCOPED_TRACE(static_cast<int>(method));
        EXPECT_LT(lines, 15);
    }
}

TEST(LineExtraction, degenerate_scans_give_no_line_and_no_crash) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const Method method : all_methods) {
        const auto extractor = extractor_of(method);
        for (const std::size_t beams : {0u, 1u, 2u, 3u, 5u, 181u, 1441u})
            for (const float r : {0.f, 3.f, 1e-30f, 1e-3f, nan, inf, -1.f}) {
                EXPECT_TRUE(lines_of(*extractor, uniform_scan(beams, M_PI, r)).empty())
                    << beams << " of " << r;
                EXPECT_TRUE(lines_of(*extractor, uniform_scan(beams, 2 * M_PI, r)).empty())
                    << beams << " of " << r;
                EXPECT_TRUE(lines_of(*extractor, uniform_scan(beams, 1e-9, r)).empty())
                    << beams << " of " << r;
            }
    }
}
