/// Fits of one line: exact on exact points, against an exhaustive search on noisy ones, unmoved by stray
/// beams.
#include <gtest/gtest.h>

#include <random>

#include "lines/line_fit.h"
#include "lines/straightness.h"
#include "property/lines_world.h"

using namespace loopline;
using namespace loopline::lines;

namespace {

/// A scan of the wall x cos(alpha) + y sin(alpha) = rho over the bearings alpha +- half.
PlanarScan wall_scan(double rho_m, double alpha_rad, double half_rad, std::size_t beams) {
    PlanarScan scan;
    scan.first_angle_rad = alpha_rad - half_rad;
    scan.angle_step_rad = 2 * half_rad / static_cast<double>(beams - 1);
    for (std::size_t i = 0; i < beams; ++i)
        scan.ranges_m.push_back(static_cast<float>(rho_m / std::cos(scan.angle_rad(i) - alpha_rad)));
    return scan;
}

const NoiseModel one_centimetre{1e-4, 0, 0};

/// The objective that a fit minimises, with weights that follow the line; the outermost points have no part
/// in it.
double chi2_of(const ScanPoints& points, double rho_m, double alpha_rad) {
    double sum = 0;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const double bearing = std::atan2(points[i].y_m, points[i].x_m);
        const double expected_m = rho_m / std::cos(bearing - alpha_rad);
        sum += std::pow((std::hypot(points[i].x_m, points[i].y_m) - expected_m) / 0.01, 2);
    }
    return sum;
}

LikelyFit likely_fit(const ScanPoints& points, const std::vector<Interval>& runs, const NormalForm& start,
                     double variance_factor, const NoiseModel& noise = one_centimetre) {
    LineFitter fitter;
    fitter.add_line(start, variance_factor);
    for (const Interval& run : runs) fitter.add_run(run);
    fitter.fit(points, noise);
    return fitter[0];
}

}  // namespace

TEST(QuickFit, is_the_total_least_squares_line_of_brute_force) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int k = 0; k < 300; ++k) {
        Moments m;
        std::vector<Eigen::Vector2d> points;
        const double direction = M_PI * unit(random), offset = 5 * unit(random), width = k % 3 == 0 ? 0 : 0.1;
        for (int i = 0; i < 3 + k % 40; ++i) {
            const double t = 4 * unit(random), d = offset + width * unit(random);
            points.emplace_back(t * std::cos(direction) - d * std::sin(direction),
                                t * std::sin(direction) + d * std::cos(direction));
            const auto& p = points.back();
            m = m + Moments{1, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y(), 0, 0};
        }
        const QuickFit fit = quick_fit(m);
        ASSERT_NEAR(std::hypot(fit.line.nx, fit.line.ny), 1, 1e-12);
        ASSERT_GE(fit.line.rho_m, 0);
        const auto cost = [&](double alpha) {  // of the best line with that normal: through the mean
            const Eigen::Vector2d n(std::cos(alpha), std::sin(alpha));
            double mean = 0, sum = 0;
            for (const auto& p : points) mean += n.dot(p);
            mean /= static_cast<double>(points.size());
            for (const auto& p : points) sum += std::pow(n.dot(p) - mean, 2);
            return sum / static_cast<double>(points.size());
        };
        double least = INFINITY;
        for (int a = 0; a < 2000; ++a) least = std::min(least, cost(M_PI * a / 2000));
        EXPECT_LE(fit.across_m2, least + 1e-12);
        EXPECT_NEAR(fit.across_m2, cost(std::atan2(fit.line.ny, fit.line.nx)), 1e-10);
    }
}

TEST(LikelyFit, is_exact_without_noise) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> rho(0.5, 20), alpha(-M_PI, M_PI), half(0.1, 1.3);
    for (int k = 0; k < 200; ++k) {
        const double rho_m = rho(random), alpha_rad = alpha(random);
        ScanPoints points;
        points.load(wall_scan(rho_m, alpha_rad, half(random), 30));
        const QuickFit start = quick_fit(points.moments({0, 30}));
        // Ranges are single precision: what they say is exact to 6e-8 of a range.
        const LikelyFit fit = likely_fit(points, {{0, 30}}, start.line, 1);
        ASSERT_TRUE(fit.valid);
        EXPECT_EQ(fit.count + fit.ends, 30u);
        EXPECT_NEAR(fit.line.rho_m, rho_m, 1e-7 * rho_m);
        EXPECT_NEAR(wrap_to_pi(std::atan2(fit.line.ny, fit.line.nx) + points.middle_angle_rad() - alpha_rad),
                    0, 1e-6);
    }
}

TEST(LikelyFit, finds_the_minimum_of_an_exhaustive_search) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise(0, 0.01);
    for (int k = 0; k < 20; ++k) {
        PlanarScan scan = wall_scan(2 + 0.1 * k, 0, 1.2, 41);
        for (float& r : scan.ranges_m) r += static_cast<float>(std::clamp(noise(random), -0.024, 0.024));
        ScanPoints points;
        points.load(scan);
        const LikelyFit fit = likely_fit(points, {{0, 41}}, quick_fit(points.moments({0, 41})).line, 4);
        ASSERT_EQ(fit.count, 39u);
        double rho_m = fit.line.rho_m, alpha_rad = std::atan2(fit.line.ny, fit.line.nx);
        EXPECT_NEAR(fit.chi2, chi2_of(points, rho_m, alpha_rad), 1e-3 * fit.chi2);
        // Pattern search from there, ever finer: nothing better within reach but by its last step.
        const double found = chi2_of(points, rho_m, alpha_rad);
        double least = found;
        for (double step = 0.02; step > 1e-7; step /= 2)
            for (bool better = true; better;) {
                better = false;
                for (const auto& [dr, da] : {std::pair{step, 0.0}, {-step, 0.0}, {0.0, step}, {0.0, -step}}) {
                    const double value = chi2_of(points, rho_m + dr, alpha_rad + da);
                    if (value < least) {
                        least = value;
                        rho_m += dr;
                        alpha_rad += da;
                        better = true;
                    }
                }
            }
        EXPECT_LT(found - least, 1e-4) << "off by more than 1 % of a sigma";
    }
}

TEST(LikelyFit, stray_beams_and_hanging_ends_do_not_move_it) {
    PlanarScan scan = wall_scan(3, 0, 0.8, 61);
    for (const std::size_t beam : {std::size_t{20}, std::size_t{41}}) scan.ranges_m[beam] += 0.08f;
    for (std::size_t i = 0; i < 3; ++i)
        scan.ranges_m[i] += 0.05f * static_cast<float>(3 - i);  // rounded corner
    scan.ranges_m[60] -= 0.1f;                                  // mixed pixel
    ScanPoints points;
    points.load(scan);
    const LikelyFit fit = likely_fit(points, {{0, 61}}, quick_fit(points.moments({0, 61})).line, 1);
    ASSERT_TRUE(fit.valid);
    EXPECT_NEAR(fit.line.rho_m, 3, 1e-5);
    EXPECT_EQ(fit.count + fit.ends, 55u);
    EXPECT_EQ(fit.first, 3u);
    EXPECT_EQ(fit.last, 59u);
}

TEST(LikelyFit, outermost_beams_say_where_a_line_ends_and_not_where_it_is) {
    // A wall x = 2 in the sensor's frame, seen at 29 to 74 degrees of incidence; a hole from beam 18 to 21.
    const double rho_m = 2;
    PlanarScan scan;
    scan.first_angle_rad = 0.5;
    scan.angle_step_rad = 0.02;
    for (std::size_t i = 0; i < 41; ++i)
        scan.ranges_m.push_back(static_cast<float>(rho_m / std::cos(scan.angle_rad(i))));
    ScanPoints points;
    points.load(scan);
    const NormalForm start = quick_fit(points.moments({0, 41})).line;
    const LikelyFit fit = likely_fit(points, {{0, 18}, {22, 41}}, start, 1);
    ASSERT_TRUE(fit.valid);
    EXPECT_EQ(fit.count, 33u);
    EXPECT_EQ(fit.first, 0u);
    EXPECT_EQ(fit.last, 40u);
    EXPECT_EQ(fit.ends, 2u);

    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    for (std::size_t i = 0; i < 41; ++i) {
        if (i == 0 || (i >= 17 && i <= 22) || i == 40) continue;
        const double phi = scan.angle_rad(i);
        const Eigen::Vector2d jacobian(-1, rho_m * std::tan(phi));
        information += jacobian * jacobian.transpose() / std::pow(0.01 * std::cos(phi), 2);
    }
    EXPECT_LT((fit.covariance * information - Eigen::Matrix2d::Identity()).norm(), 1e-3);

    // Runs that touch are one: no end between them.
    EXPECT_EQ(likely_fit(points, {{0, 20}, {20, 41}}, start, 1).covariance,
              likely_fit(points, {{0, 41}}, start, 1).covariance);

    // A beam that meets the jamb behind the wall's end, within what noise may be.
    scan.ranges_m[40] -= 0.025f;
    points.load(scan);
    const LikelyFit drawn = likely_fit(points, {{0, 18}, {22, 41}}, start, 1);
    EXPECT_EQ(drawn.line.nx, fit.line.nx);
    EXPECT_EQ(drawn.line.rho_m, fit.line.rho_m);

    // A fine sensor has more beams in what noise hides of an end: 3 cm here.
    scan.first_angle_rad = -0.4;
    scan.angle_step_rad = 0.002;
    scan.ranges_m.clear();
    for (std::size_t i = 0; i < 401; ++i)
        scan.ranges_m.push_back(static_cast<float>(rho_m / std::cos(scan.angle_rad(i))));
    points.load(scan);
    const NormalForm fine_start = quick_fit(points.moments({0, 401})).line;
    const std::size_t hidden = 401 - likely_fit(points, {{0, 401}}, fine_start, 1).count;
    EXPECT_GE(hidden, 2 * 6u);
    EXPECT_LE(hidden, 2 * 8u);
}

TEST(LikelyFit, says_no_where_there_is_no_line) {
    ScanPoints points;
    PlanarScan one_spot = wall_scan(3, 0, 0.8, 5);
    one_spot.angle_step_rad = 1e-18;  // all beams alike
    one_spot.ranges_m.assign(5, 3);
    points.load(one_spot);
    EXPECT_FALSE(likely_fit(points, {{0, 5}}, {}, 1).valid);
    EXPECT_FALSE(likely_fit(points, {}, {}, 1).valid);
}

TEST(Chi2Limit, agrees_with_tables) {
    // 0.999 quantiles of chi-square.
    for (const auto& [degrees, quantile] :
         {std::pair{1.0, 10.828}, {5.0, 20.515}, {30.0, 59.703}, {100.0, 149.449}})
        EXPECT_NEAR(chi2_per_degree_limit(degrees) * degrees, quantile, 0.035 * quantile);
}

TEST(Straightness, tells_walls_bends_and_corners) {
    std::mt19937_64 random(6);
    for (int k = 0; k < 100; ++k) {
        lines_world::World wall, round, corner;
        wall.walls.push_back({{3, -3}, {3, 3}});
        round.circles.push_back({{6, 0}, 3.0 + 0.01 * k});
        corner.walls.push_back({{3.4, -2}, {3, 0}});
        corner.walls.push_back({{3, 0}, {3.4, 2}});
        const auto shape = [&](const lines_world::World& world) {
            lines_world::Sensor sensor;
            sensor.beams = 81;
            sensor.aperture_rad = 0.6;
            auto sweep = lines_world::sweep(world, sensor);
            lines_world::add_range_noise(sweep, 0.01, random);
            ScanPoints points;
            points.load(sweep.scan);
            const Interval all{0, points.size()};
            const Straightness result = straightness(points, all, one_centimetre, 0.005);
            const double left_m2 = squares_left_by_parabola_m2(points, all, result.fit.line);
            return std::pair{result, left_m2 < 1.5 * 1e-4 * static_cast<double>(points.size())};
        };
        EXPECT_EQ(shape(wall).first.shape, Shape::straight);
        const auto [bend, smooth] = shape(round);
        EXPECT_EQ(bend.shape, Shape::bent);
        EXPECT_TRUE(smooth);
        EXPECT_LT(bend.sagitta_m, 0) << "a pillar's middle is nearer than its chord";
        EXPECT_EQ(shape(corner).first.shape, Shape::bent);
        EXPECT_FALSE(shape(corner).second) << "two walls are no bend";
    }
}
