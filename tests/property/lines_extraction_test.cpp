/// Line extraction on random polygon worlds: against truth, against exhaustive segmentation, and what must
/// not change it.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <random>

#include "lines/line_extractor.h"
#include "lines/line_fit.h"
#include "lines/splitting.h"
#include "property/lines_truth.h"
#include "property/lines_world.h"

using namespace loopline;
using namespace loopline::lines;
using lines_world::Score;
using lines_world::Sensor;
using lines_world::Sweep;
using lines_world::World;

namespace {

constexpr Method all_methods[] = {Method::angle_threshold, Method::split_and_merge, Method::incremental};

std::unique_ptr<LineExtractor> extractor_of(Method method) {
    ExtractionParameters parameters;
    parameters.method = method;
    parameters.sigma_wall_m = 0;
    return make_line_extractor(parameters);
}

LineSegments lines_of(LineExtractor& extractor, const PlanarScan& scan) {
    LineSegments segments;
    extractor.extract(scan, segments);
    return segments;
}

/// World k of a series, seen from a random place near its middle.
Sweep random_sweep(int k, double sigma_m, std::mt19937_64& random, World& world, Sensor& sensor) {
    std::uniform_real_distribution<double> unit(0, 1);
    world = lines_world::random_world(random, 4 + k % 5, k % 4);
    sensor.beams = k % 2 ? 181 : 361;
    sensor.T_world_sensor = {0.5 * unit(random), 0.5 * unit(random), 2 * M_PI * unit(random)};
    Sweep sweep = lines_world::sweep(world, sensor);
    lines_world::add_range_noise(sweep, sigma_m, random);
    return sweep;
}

/// The line of `segments` nearest to `line`, in the line's sigmas; infinite if none points the same way.
double nearest_in_sigmas(const LineSegment& line, const LineSegments& segments) {
    double nearest = INFINITY;
    for (const auto& s : segments) {
        const Eigen::Vector2d d(s.rho_m - line.rho_m, wrap_to_pi(s.alpha_rad - line.alpha_rad));
        if (std::abs(d(1)) > 0.2 || (s.start_m - line.start_m).norm() > line.length_m()) continue;
        nearest = std::min(nearest, std::sqrt(d.dot(line.covariance.inverse() * d)));
    }
    return nearest;
}

PlanarScan uniform_scan(std::size_t beams, double sweep_rad, float range_m) {
    PlanarScan scan;
    scan.first_angle_rad = -sweep_rad / 2;
    scan.angle_step_rad = beams > 1 ? sweep_rad / static_cast<double>(beams - 1) : 0.01;
    scan.max_range_m = 80;
    scan.ranges_m.assign(beams, range_m);
    return scan;
}

}  // namespace

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

TEST(BestBreak, is_that_of_an_exhaustive_search_at_a_corner) {
    std::mt19937_64 random(41);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int k = 0; k < 200; ++k) {
        World world;
        const Eigen::Vector2d corner(2 + 2 * unit(random), 0.5 - unit(random));
        world.walls.push_back({corner + Eigen::Vector2d(4 * unit(random) - 3, -4), corner});
        world.walls.push_back({corner, corner + Eigen::Vector2d(4 * unit(random) - 3, 4)});
        Sensor sensor;
        sensor.beams = 121;
        sensor.aperture_rad = 1.2;
        Sweep sweep = lines_world::sweep(world, sensor);
        lines_world::add_range_noise(sweep, 0.005, random);
        ScanPoints points;
        points.load(sweep.scan);
        const Interval all{0, points.size()};
        const auto squares = [&](std::size_t from, std::size_t to) {
            if (to - from < 3) return 0.0;
            const Moments m = points.moments({from, to});
            return m.n * quick_fit(m).across_m2;
        };
        double least = INFINITY;
        for (std::size_t b = 1; b < all.end; ++b)
            least = std::min(least, squares(0, b) + squares(b, all.end));
        EXPECT_LE(best_break(points, all).squares_m2, least + 1e-6 + 0.02 * least);
    }
}

TEST(LineExtraction, breaks_are_those_of_the_optimal_segmentation) {
    std::mt19937_64 random(42);
    for (const Method method : {Method::angle_threshold, Method::split_and_merge}) {
        const auto extractor = extractor_of(method);
        int walls = 0, agreed = 0;
        for (int k = 0; k < 60; ++k) {
            World world = lines_world::random_world(random, 4 + k % 4, 0);
            Sensor sensor;
            sensor.T_world_sensor.phi_rad = 0.1 * k;
            Sweep sweep = lines_world::sweep(world, sensor);
            lines_world::add_range_noise(sweep, 0.01, random);
            ScanPoints points;
            points.load(sweep.scan);
            // Dynamic programming over all segmentations: squares in units of the noise, and a price per
            // line.
            const std::size_t n = points.size();
            const double price = 30, sigma2 = 1e-4;
            std::vector<double> best(n + 1, INFINITY);
            std::vector<std::size_t> from(n + 1, 0);
            best[0] = 0;
            const NoiseModel noise{sigma2, 0, 0};
            for (std::size_t end = 3; end <= n; ++end)
                for (std::size_t begin = 0; begin + 3 <= end; ++begin) {
                    const Moments m = points.moments({begin, end});
                    const QuickFit fit = quick_fit(m);
                    const double value =
                        best[begin] + price + m.n * fit.across_m2 / noise.mean_variance_m2(m, fit);
                    if (value < best[end]) {
                        best[end] = value;
                        from[end] = begin;
                    }
                }
            const auto segments = lines_of(*extractor, sweep.scan);
            for (std::size_t end = n; end > 0; end = from[end]) {
                const std::size_t first = points[from[end]].beam, last = points[end - 1].beam;
                if (end - from[end] < 10 || points.squared_distance_m2(from[end], end - 1) < 1) continue;
                ++walls;
                for (const auto& s : segments)
                    if (std::abs(static_cast<double>(s.first_beam) - static_cast<double>(first)) <= 2 &&
                        std::abs(static_cast<double>(s.last_beam) - static_cast<double>(last)) <= 2) {
                        ++agreed;
                        break;
                    }
            }
        }
        SCOPED_TRACE(static_cast<int>(method));
        EXPECT_GT(walls, 150);
        EXPECT_GT(agreed, 0.93 * walls);
    }
}
