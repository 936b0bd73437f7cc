/// Fixes that are stamped late, against a path that knows its own motion.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "fusion/fix_lag.h"

using namespace loopline::fusion;

namespace {

/// Five minutes through a town: speed and heading swing.
struct TownDrive {
    std::vector<PlaceAt> path;  ///< ten times a second
    double speed_mps(double t) const { return 7 + 5 * std::sin(t / 6); }
    double rate_radps(double t) const { return 0.25 * std::sin(t / 9 + 1); }
    std::vector<PlaceAt> driven(double scale, bool steady) const {
        constexpr double dt = 0.01;
        std::vector<PlaceAt> places;
        Eigen::Vector2d p_m(0, 0);
        double heading_rad = 0.4;
        for (int k = 0; k <= 30000; ++k) {
            if (k % 10 == 0) places.push_back({k * dt, p_m});
            const double t = k * dt;
            heading_rad += steady ? 0 : rate_radps(t) * dt;
            p_m += scale * (steady ? 7 : speed_mps(t)) * dt *
                   Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
        }
        return places;
    }
};

std::vector<PlaceAt> fixes_of(const std::vector<PlaceAt>& truth, double lag_s,
                              const std::function<Eigen::Vector2d(double)>& error_m) {
    std::vector<PlaceAt> fixes;
    const Eigen::Rotation2Dd turn(2.2);
    for (std::size_t k = 0; k < truth.size(); k += 2)
        fixes.push_back({truth[k].time_s + lag_s,
                         turn * truth[k].p_m + Eigen::Vector2d(100, -40) + error_m(truth[k].time_s)});
    return fixes;
}

}  // namespace

TEST(FixLag, is_found_within_what_it_claims) {
    const auto truth = TownDrive().driven(1, false), wheels = TownDrive().driven(1.03, false);
    for (const double lag_s : {0.4, -0.12, 0.0}) {
        double squares = 0;
        constexpr int runs = 30;
        for (int seed = 0; seed < runs; ++seed) {
            std::mt19937_64 random(static_cast<std::uint64_t>(seed));
            std::normal_distribution<double> normal;
            Eigen::Vector2d slow_m(0, 0);
            const auto error_m = [&](double) -> Eigen::Vector2d {
                slow_m = 0.995 * slow_m + 0.1 * Eigen::Vector2d(normal(random), normal(random));  // 1 m, 40 s
                return slow_m + 0.05 * Eigen::Vector2d(normal(random), normal(random));
            };
            const auto found = lag_of_fixes(seed % 2 == 0 ? truth : wheels, fixes_of(truth, lag_s, error_m));
            ASSERT_TRUE(found) << seed;
            EXPECT_LT(found->sigma_s, 0.1);
            EXPECT_NEAR(found->lag_s, lag_s, 5 * found->sigma_s);
            squares += std::pow((found->lag_s - lag_s) / found->sigma_s, 2) / runs;
        }
        EXPECT_LT(squares, 3) << lag_s;
    }
}

TEST(FixLag, of_reflected_signals_and_poor_fixes_is_none_that_matters) {
    const auto truth = TownDrive().driven(1, false);
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        std::mt19937_64 random(seed);
        std::normal_distribution<double> normal;
        const auto error_m = [&](double t) -> Eigen::Vector2d {
            const bool reflected = std::fmod(t + 3 * double(seed), 30) < 10;
            return (reflected ? Eigen::Vector2d(12, -9) : Eigen::Vector2d(0, 0)) +
                   0.02 * Eigen::Vector2d(normal(random), normal(random));
        };
        const auto found = lag_of_fixes(truth, fixes_of(truth, 0, error_m));
        ASSERT_TRUE(found) << seed;
        EXPECT_LT(std::abs(found->lag_s), std::max(0.02, 4 * found->sigma_s)) << seed;
    }
}

// At one speed straight on, late fixes are where others would be a little further back.
TEST(FixLag, is_not_told_where_nothing_changes) {
    const auto truth = TownDrive().driven(1, true);
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    const auto error_m = [&](double) -> Eigen::Vector2d {
        return 0.02 * Eigen::Vector2d(normal(random), normal(random));
    };
    EXPECT_FALSE(lag_of_fixes(truth, fixes_of(truth, 0.4, error_m)));
    EXPECT_FALSE(lag_of_fixes({}, {}));
    EXPECT_FALSE(lag_of_fixes(truth, {}));
}
