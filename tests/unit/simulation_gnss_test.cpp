/// The satellite receiver: errors of the statistics asked for, moments, places, and what it says of itself.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>

#include <cmath>

#include "gnss/gps_observation.h"
#include "simulation/gnss_sensor.h"
#include "support/run_program.h"
#include "support/simulated_scene.h"

#ifdef LOOPLINE_HAS_GEOGRAPHICLIB
#include <GeographicLib/LocalCartesian.hpp>
#endif

using namespace loopline;
using namespace loopline::simulation;
using namespace loopline::test;
using gnss::FixQuality;
using gnss::GnssFix;

namespace {

const std::vector<std::string> exact_gnss{"gnss.fixed_white_m=0", "gnss.fixed_correlated_m=0",
                                          "gnss.sigma_velocity_mps=0"};

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// A drive with a receiver, and what it said.
struct GnssDrive {
    std::unique_ptr<Scene> scene;
    std::vector<GnssFix> fixes;
    std::vector<StampNs> log_times_ns;  ///< when each came, since the start
    std::vector<TruthRow> truth;
    gnss::GeoReference reference;

    Eigen::Vector3d p_map_antenna_m(const GnssFix& fix) const {
        return scene->drive.motion.pose_at(fix.stamp_ns - scene->start_ns) * fix.p_base_antenna_m;
    }
    Eigen::Vector3d error_enu_m(const GnssFix& fix) const {
        return reference.R_enu_map() * (reference.p_map_m(fix.antenna) - p_map_antenna_m(fix));
    }
};

/// `section`: more lines of [gnss].
GnssDrive driven_with_gnss(std::vector<std::string> overrides, const std::string& section = "") {
    TemporaryFolder folder;
    const std::string scenario =
        folder.write("floor.ini", file_text(test_scenario("cart_floor.ini")) + "\n[gnss]\n" + section);

    overrides.push_back("simulation.sensors=gnss");
    WorldSimulator simulator;
    load_scenario(scenario, overrides, simulator);
    GnssDrive drive;
    drive.scene = make_scene(simulator.scenario());
    auto* const sensor = dynamic_cast<GnssSensor*>(simulator.sensors_in_use().front());
    sensor->start(*drive.scene);
    drive.reference = sensor->geo_reference();
    while (sensor->next_time_ns() <= drive.scene->duration_ns()) {
        drive.log_times_ns.push_back(sensor->next_time_ns());
        const auto o = std::dynamic_pointer_cast<mrpt::obs::CObservationGPS>(sensor->next());
        drive.fixes.push_back(*gnss::fix_from_mrpt(*o, *stamp_from_mrpt(o->timestamp)));
    }
    drive.truth = sensor->truth();
    return drive;
}

}  // namespace

TEST(GnssErrors, deviations_and_correlation_are_those_asked_for) {
    GnssErrorSettings settings;
    settings.fixed = {0.03, 0.04, 8};
    settings.floating = {0.1, 0.5, 4};
    settings.single = {0.5, 2, 2};
    constexpr int receivers = 4000, lag = 10;
    const FixQuality kinds[] = {FixQuality::rtk_fixed, FixQuality::rtk_float, FixQuality::single};
    const PositionNoise noises[] = {settings.fixed, settings.floating, settings.single};
    Eigen::Vector3d squares_m2[3], products_m2[3];
    for (int k = 0; k < 3; ++k) squares_m2[k] = products_m2[k] = Eigen::Vector3d::Zero();
    for (int i = 0; i < receivers; ++i) {
        GnssErrors errors(settings, 5, static_cast<std::uint64_t>(i));
        errors.advance();
        Eigen::Vector3d first_m[3];
        for (int k = 0; k < 3; ++k) first_m[k] = errors.position_enu_m(kinds[k]);
        for (int step = 0; step < lag; ++step) errors.advance();
        for (int k = 0; k < 3; ++k) {
            squares_m2[k] += first_m[k].cwiseAbs2() / receivers;
            products_m2[k] += first_m[k].cwiseProduct(errors.position_enu_m(kinds[k])) / receivers;
        }
    }
    for (int k = 0; k < 3; ++k) {
        const PositionNoise& n = noises[k];
        const Eigen::Vector3d vertical(1, 1, settings.vertical_factor * settings.vertical_factor);
        const double variance_m2 = n.white_m * n.white_m + n.correlated_m * n.correlated_m;
        const double covariance_m2 = n.correlated_m * n.correlated_m * std::exp(-lag / 5.0 / n.correlation_s);
        for (int axis = 0; axis < 3; ++axis) {
            // Both are means of 4 000 products of normal numbers.
            const double tolerance_m2 = 5 * variance_m2 * vertical[axis] * std::sqrt(2.0 / receivers);
            EXPECT_NEAR(squares_m2[k][axis], variance_m2 * vertical[axis], tolerance_m2) << k << axis;
            EXPECT_NEAR(products_m2[k][axis], covariance_m2 * vertical[axis], tolerance_m2) << k << axis;
        }
        const Eigen::Vector3d reported_m = GnssErrors(settings, 5, 1).sigma_enu_m(kinds[k]);
        EXPECT_NEAR(reported_m.x(), std::sqrt(variance_m2), 1e-12);
        EXPECT_NEAR(reported_m.z(), 2 * std::sqrt(variance_m2), 1e-12);
    }
}

TEST(GnssErrors, white_noise_is_white_and_slow_noise_stays) {
    GnssErrorSettings settings;
    settings.fixed = {0, 1, 60};
    settings.single = {1, 0, 60};
    GnssErrors errors(settings, 5, 7);
    double white_product = 0, slow_step2 = 0;
    constexpr int count = 50000;
    errors.advance();
    Eigen::Vector3d white = errors.position_enu_m(FixQuality::single),
                    slow = errors.position_enu_m(FixQuality::rtk_fixed);
    for (int i = 0; i < count; ++i) {
        errors.advance();
        const Eigen::Vector3d next = errors.position_enu_m(FixQuality::single),
                              slow_next = errors.position_enu_m(FixQuality::rtk_fixed);
        white_product += white.x() * next.x() / count;
        slow_step2 += std::pow(slow_next.y() - slow.y(), 2) / count;
        white = next;
        slow = slow_next;
    }
    EXPECT_NEAR(white_product, 0, 5 / std::sqrt(count));
    // A Gauss-Markov process moves by 2 (1 - exp(-dt / tau)) of its variance.
    const double expected = 2 * (1 - std::exp(-0.2 / 60));
    EXPECT_NEAR(slow_step2, expected, 5 * expected * std::sqrt(2.0 / count));
}

TEST(GnssErrors, multipath_comes_as_often_and_as_long_as_asked_for) {
    GnssErrorSettings settings;
    settings.multipath_per_min = 6;
    settings.multipath_m = 15;
    settings.multipath_s = 4;
    settings.multipath_noticed = 0.25;
    GnssErrors errors(settings, 5, 3);
    int jumps = 0, noticed = 0, steps_in_jump = 0;
    constexpr int steps = 5 * 3600 * 10;
    Eigen::Vector3d before_m = Eigen::Vector3d::Zero();
    for (int i = 0; i < steps; ++i) {
        errors.advance();
        const Eigen::Vector3d& now_m = errors.multipath_enu_m();
        if (now_m.norm() > 0) {
            ++steps_in_jump;
            ASSERT_GE(now_m.head<2>().norm(), 9 - 1e-9);
            ASSERT_LE(now_m.head<2>().norm(), 21 + 1e-9);
            if (now_m != before_m) {
                ++jumps;
                noticed += errors.multipath_noticed();
            }
        }
        before_m = now_m;
    }
    // Jumps begin at their rate while there is none: one in 10 s + its own length.
    const double length_s = 0.2 * steps_in_jump / jumps;
    const double expected = 36000 / (10 + length_s);
    EXPECT_NEAR(jumps, expected, 5 * std::sqrt(expected));
    // Exponential, but at least 0.5 s: 0.5 + integral of the tail; and up to one interval more.
    EXPECT_NEAR(length_s, 4 * std::exp(-0.125) + 0.5, 0.4);
    EXPECT_NEAR(static_cast<double>(noticed) / jumps, 0.25, 5 * std::sqrt(0.19 / jumps));
}

TEST(GnssSky, times_go_before_zones_and_zones_before_ways) {
    GnssSky sky;
    sky.by_way = {{10, 20, 5}, {15, 18, 1}};
    sky.by_zone = {{5, 5, -5, -5, 0}};
    sky.by_time = {{100, 200, 4}};
    const Eigen::Vector2d here(0, 0), there(50, 0);
    EXPECT_EQ(sky.at(0, 0, there), FixQuality::rtk_fixed);
    EXPECT_EQ(sky.at(0, 12, there), FixQuality::rtk_float);
    EXPECT_EQ(sky.at(0, 16, there), FixQuality::single) << "the last row counts";
    EXPECT_EQ(sky.at(0, 16, here), FixQuality::invalid);
    EXPECT_EQ(sky.at(150, 16, here), FixQuality::rtk_fixed);
    EXPECT_EQ(sky.check(), "");
    sky.by_way.push_back({1, 2, 2});
    EXPECT_NE(sky.check(), "");
}

TEST(SimulatedGnss, without_errors_it_is_where_the_antenna_is_on_the_earth) {
    const auto drive = driven_with_gnss(
        exact_gnss + std::vector<std::string>{"gnss.x_m=-0.7", "gnss.y_m=0.2", "gnss.z_m=1.5",
                                              "gnss.latitude_deg=-35.3", "gnss.longitude_deg=149.1",
                                              "gnss.height_m=580", "gnss.heading_deg=-72"});
    ASSERT_GT(drive.fixes.size(), 1000u);
    EXPECT_EQ(drive.truth.size(), drive.fixes.size() + 1);
    EXPECT_EQ(drive.truth[0].values, (std::vector<double>{-35.3, 149.1, 580, -72}));
    double most_m = 0;
    for (std::size_t i = 0; i < drive.fixes.size(); ++i) {
        const GnssFix& fix = drive.fixes[i];
        EXPECT_EQ(fix.p_base_antenna_m, Eigen::Vector3d(-0.7, 0.2, 1.5));
        EXPECT_EQ(fix.utc_ns, fix.stamp_ns);
        ASSERT_NEAR(drive.error_enu_m(fix).norm(), 0, 1e-7);
        const Eigen::Vector3d p_map_m = drive.p_map_antenna_m(fix);
        const auto& row = drive.truth[i + 1].values;
        ASSERT_EQ(p_map_m, Eigen::Vector3d(row[0], row[1], row[2]));
        most_m = std::max(most_m, p_map_m.norm());
#ifdef LOOPLINE_HAS_GEOGRAPHICLIB
        const GeographicLib::LocalCartesian local(-35.3, 149.1, 580);
        double east_m = 0, north_m = 0, up_m = 0;
        local.Forward(fix.antenna.latitude_deg, fix.antenna.longitude_deg, fix.antenna.height_m, east_m,
                      north_m, up_m);
        // The map's x axis points 72 degrees to the right of east.
        const double c = std::cos(72 * M_PI / 180), s = std::sin(72 * M_PI / 180);
        ASSERT_NEAR(east_m, c * p_map_m.x() + s * p_map_m.y(), 1e-7);
        ASSERT_NEAR(north_m, -s * p_map_m.x() + c * p_map_m.y(), 1e-7);
        ASSERT_NEAR(up_m, p_map_m.z(), 1e-7);
#endif
    }
    EXPECT_GT(most_m, 10);
}

TEST(SimulatedGnss, speed_and_course_are_those_of_the_antenna) {
    const auto drive = driven_with_gnss(exact_gnss);
    int moving = 0;
    for (std::size_t i = 1; i + 1 < drive.fixes.size(); ++i) {
        const GnssFix &before = drive.fixes[i - 1], &after = drive.fixes[i + 1], &fix = drive.fixes[i];
        const double duration_s = seconds_between(before.stamp_ns, after.stamp_ns);
        const Eigen::Vector2d v_enu_mps =
            (drive.reference.R_enu_map() * (drive.p_map_antenna_m(after) - drive.p_map_antenna_m(before)))
                .head<2>() /
            duration_s;
        const Eigen::Vector2d said_mps =
            *fix.speed_mps * Eigen::Vector2d(std::cos(*fix.course_rad), std::sin(*fix.course_rad));
        ASSERT_LT((said_mps - v_enu_mps).norm(), 0.15) << "the mean over 0.4 s, and in bends";
        moving += v_enu_mps.norm() > 0.5;
    }
    EXPECT_GT(moving, 500);
}

TEST(SimulatedGnss, fixes_come_late_and_in_their_order) {
    const std::vector<std::string> late{"gnss.latency_s=0.3", "gnss.latency_spread_s=0.5", "gnss.rate_hz=10"};
    const auto drive = driven_with_gnss(late);
    double least_s = 9, most_s = 0;
    for (std::size_t i = 0; i < drive.fixes.size(); ++i) {
        const GnssFix& fix = drive.fixes[i];
        ASSERT_EQ(fix.stamp_ns - drive.scene->start_ns, static_cast<StampNs>(i) * 100'000'000);
        ASSERT_EQ(*fix.received_ns - drive.scene->start_ns, drive.log_times_ns[i]);
        ASSERT_TRUE(i == 0 || drive.log_times_ns[i] > drive.log_times_ns[i - 1]);
        const double latency_s = seconds_between(fix.stamp_ns, *fix.received_ns);
        least_s = std::min(least_s, latency_s);
        most_s = std::max(most_s, latency_s);
    }
    EXPECT_NEAR(least_s, 0.3, 0.02);
    EXPECT_NEAR(most_s, 0.8, 0.02);
    // A log whose stamps are the computer's: the receiver's own time still says when it was.
    const auto stamped = driven_with_gnss(late + std::vector<std::string>{"gnss.stamp=reception"});
    ASSERT_EQ(stamped.fixes.size(), drive.fixes.size());
    for (std::size_t i = 0; i < drive.fixes.size(); ++i) {
        ASSERT_EQ(stamped.fixes[i].stamp_ns, *drive.fixes[i].received_ns);
        ASSERT_EQ(*stamped.fixes[i].utc_ns, drive.fixes[i].stamp_ns);
    }
}

TEST(SimulatedGnss, kinds_of_fix_keep_to_the_schedule_and_change_no_noise) {
    const auto fixed = driven_with_gnss({});
    const auto drive =
        driven_with_gnss({"gnss.refix_s=4.1", "gnss.reported_sigma_factor=0.5"},
                         "state_s = 19.9 30.1 0\nstate_s = 59.9 69.9 1\nstate_s = 69.9 80.1 5\n");
    ASSERT_EQ(drive.fixes.size(), fixed.fixes.size());
    for (std::size_t i = 0; i < drive.fixes.size(); ++i) {
        const GnssFix& fix = drive.fixes[i];
        const double time_s = seconds_between(drive.scene->start_ns, fix.stamp_ns);
        const auto within = [&](double from, double to) { return time_s >= from && time_s <= to; };
        const FixQuality expected = within(69.9, 80.1)   ? FixQuality::rtk_float
                                    : within(59.9, 69.9) ? FixQuality::single
                                    : within(30.1, 34.1) ? FixQuality::rtk_float
                                    : within(19.9, 30.1) ? FixQuality::invalid
                                                         : FixQuality::rtk_fixed;
        ASSERT_EQ(fix.quality, expected) << time_s;
        EXPECT_EQ(fix.is_usable(), expected != FixQuality::invalid);
        EXPECT_EQ(drive.truth[i + 1].values[3], static_cast<double>(expected));
        if (expected == FixQuality::invalid) continue;
        if (expected == FixQuality::rtk_fixed) {
            ASSERT_EQ(fix.antenna.latitude_deg, fixed.fixes[i].antenna.latitude_deg);
            ASSERT_EQ(fix.satellites, fixed.fixes[i].satellites);
            EXPECT_NEAR(fix.sigma_enu_m->x(), 0.5 * std::hypot(0.01, 0.004), 1e-8);
        }
        const double range_ratio = std::sqrt(fix.satellites - 3.0) * *fix.hdop;
        EXPECT_NEAR(range_ratio, 2.1, 1e-5) << "HDOP belongs to the satellites";
    }
}

TEST(SimulatedGnss, multipath_is_in_the_truth_and_not_in_what_it_says) {
    const auto drive = driven_with_gnss({"gnss.multipath_per_min=6", "gnss.multipath_noticed=0.5"});
    int jumped = 0, believed = 0;
    for (std::size_t i = 0; i < drive.fixes.size(); ++i) {
        const GnssFix& fix = drive.fixes[i];
        const double jump_m = drive.truth[i + 1].values[4], error_m = drive.error_enu_m(fix).norm();
        if (jump_m == 0) {
            EXPECT_EQ(fix.quality, FixQuality::rtk_fixed);
            EXPECT_LT(error_m, 0.15);
            continue;
        }
        ++jumped;
        EXPECT_GT(jump_m, 8);
        if (fix.quality == FixQuality::rtk_fixed) {
            ++believed;
            EXPECT_NEAR(error_m, jump_m, 0.15);
            EXPECT_LT(fix.sigma_enu_m->norm(), 0.05);
        } else {
            EXPECT_EQ(fix.quality, FixQuality::single);
        }
    }
    EXPECT_GT(jumped, 50);
    EXPECT_GT(believed, 10);
    EXPECT_LT(believed, jumped);
}
