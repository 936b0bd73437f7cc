/// Where runs of beams are split: against exhaustive search, and the cases in which it matters.
#include <gtest/gtest.h>

#include <random>

#include "lines/line_fit.h"
#include "lines/splitting.h"
#include "property/lines_extracted.h"

using namespace loopline;
using namespace loopline::lines;
using namespace lines_world;

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

/// A corridor's right wall with the recess of a door, 15 cm deep and 1 m wide, that begins `ahead_m` ahead;
/// and the corridor's end.
World wall_with_a_door(double ahead_m) {
    const double y = -1.2, back = y - 0.15, from = ahead_m, to = ahead_m + 1;
    World world;
    world.walls = {{{-6, y}, {from, y}},  {{from, y}, {from, back}}, {{from, back}, {to, back}},
                   {{to, back}, {to, y}}, {{to, y}, {to + 0.6, y}},  {{to + 0.6, y}, {to + 0.6, 1}}};
    return world;
}

TEST(LineExtraction, noise_excuses_no_step_between_two_walls) {
    std::mt19937_64 random(43);
    int found = 0;
    for (const Method method : {Method::angle_threshold, Method::split_and_merge}) {
        const auto extractor = extractor_of(method);
        for (int k = 0; k < 400; ++k) {
            const World world = wall_with_a_door(0.1 + 0.005 * k);
            Sensor sensor;
            Sweep sweep = lines_world::sweep(world, sensor);
            lines_world::add_range_noise(sweep, 0.01, random);
            for (const LineSegment& line : lines_of(*extractor, sweep.scan)) {
                ++found;
                const double off_rad = std::remainder(line.alpha_rad, M_PI / 2);
                EXPECT_LT(std::abs(off_rad), std::max(0.05, 4 * std::sqrt(line.covariance(1, 1))))
                    << "wall or door, but nothing across both, " << k;
            }
        }
    }
    EXPECT_GT(found, 1600);
}

TEST(LineExtraction, a_jamb_does_not_turn_its_door_on_the_average) {
    // Beams on the jamb near its corner may pass for the door's; always those on the far side.
    std::mt19937_64 random(44);
    const auto extractor = extractor_of(Method::split_and_merge);
    double sum_rad = 0, claimed_rad2 = 0;
    int n = 0;
    for (int k = 0; k < 3000; ++k) {
        const World world = wall_with_a_door(0.3 + 0.0003 * k);
        Sensor sensor;
        Sweep sweep = lines_world::sweep(world, sensor);
        lines_world::add_range_noise(sweep, 0.01, random);
        for (const LineSegment& line : lines_of(*extractor, sweep.scan)) {
            if (std::abs(line.rho_m - 1.35) > 0.05 || std::abs(line.alpha_rad + M_PI / 2) > 0.2) continue;
            sum_rad += line.alpha_rad + M_PI / 2;
            claimed_rad2 += line.covariance(1, 1);
            ++n;
        }
    }
    ASSERT_GT(n, 2000);
    EXPECT_LT(std::abs(sum_rad / n), 0.1 * std::sqrt(claimed_rad2 / n)) << "of " << n;
}
