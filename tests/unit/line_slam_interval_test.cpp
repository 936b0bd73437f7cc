/// Wide interval and re-prediction against the motion they stand for.
#include <gtest/gtest.h>

#include <random>

#include "line_slam/wide_interval.h"

using namespace loopline;
using namespace loopline::line_slam;

namespace {

constexpr double scan_s = 1.0 / 37, straight_mps = 0.1023, outer_mps = 0.0634, inner_mps = 0.0106;

struct Vehicle {
    DriveParameters drive;
    IntervalParameters interval;
    Vehicle() {
        drive.track_width_m = 0.4;
        interval.scans = 20;
        interval.regimes[0].commanded = {straight_mps, straight_mps};
        interval.regimes[1].commanded = {inner_mps, outer_mps};
        interval.regimes[2].commanded = {outer_mps, inner_mps};
    }
    Pose2 motion(Regime regime) const {
        const WheelSpeed v = interval.regimes[static_cast<std::size_t>(regime)].commanded;
        return moved({v.left_mps * scan_s, v.right_mps * scan_s, 0}, drive.track_width_m);
    }
    Pose2 predicted(const WideInterval& wide) const {
        Pose2 T;
        for (const MotionPiece& p : wide.pieces()) T = T * moved(p.travel, drive.track_width_m);
        return T;
    }
};

/// An interval and a vehicle that drives through it.
struct Course {
    const Vehicle& vehicle;
    WideInterval wide{vehicle.interval, vehicle.drive};
    Pose2 T_odom_base{3, -2, 1};

    explicit Course(const Vehicle& v) : vehicle(v) {
        EXPECT_TRUE(wide.add({T_odom_base, 0, {}})) << "the first scan is a step";
        wide.restart();
    }
    bool add(const Pose2& motion, std::optional<Regime> commanded = {}) {
        T_odom_base = T_odom_base * motion;
        return wide.add({T_odom_base, scan_s, commanded});
    }
    bool drive(Regime regime) { return add(vehicle.motion(regime)); }
};

void expect_same(const Pose2& a, const Pose2& b, double tolerance_m) {
    EXPECT_LT((a.translation() - b.translation()).norm(), tolerance_m);
    EXPECT_LT(std::abs(wrap_to_pi(a.phi_rad - b.phi_rad)), 10 * tolerance_m);
}

TEST(WideInterval, every_nth_scan_is_a_step) {
    const Vehicle v;
    Course course(v);
    WideInterval& wide = course.wide;
    for (int i = 1; i <= 60; ++i) {
        const bool due = course.drive(Regime::straight);
        EXPECT_EQ(due, i % 20 == 0) << i;
        if (!due) continue;
        EXPECT_EQ(wide.pieces().size(), 1u);
        expect_same(v.predicted(wide), {20 * scan_s * straight_mps, 0, 0}, 1e-12);
        wide.restart();
    }
    EXPECT_EQ(wide.re_predictions(), 0);
}

TEST(WideInterval, is_split_at_every_change_of_the_regime) {
    for (const auto control :
         {IntervalParameters::Control::measured, IntervalParameters::Control::commanded}) {
        Vehicle v;
        v.interval.control = control;
        Course course(v);
        WideInterval& wide = course.wide;
        for (int i = 0; i < 20; ++i) course.drive(Regime::straight);
        wide.restart();
        // Eq. (7)-(10) with two changes in one interval: 6 scans straight, 9 to the left, 5 straight.
        Pose2 truth;
        for (int i = 0; i < 20; ++i) {
            const Pose2 motion = v.motion(i < 6 || i >= 15 ? Regime::straight : Regime::left);
            truth = truth * motion;
            EXPECT_EQ(course.add(motion), i == 19);
        }
        EXPECT_EQ(wide.pieces().size(), 3u);
        EXPECT_EQ(wide.re_predictions(), 2);
        expect_same(v.predicted(wide), truth, 1e-6);
        expect_same(wide.T_step_base(), truth, 1e-12);
    }
}

TEST(WideInterval, scans_between_steps_are_where_the_filter_would_predict_them) {
    Vehicle v;
    for (RegimeParameters& r : v.interval.regimes) r.slip_left = 0.1, r.slip_right = 0.02;
    const WheelCalibration calibration{0.01, -0.02, 0.03};
    Course course(v);
    Pose2 truth;
    for (int i = 0; i < 20; ++i) {
        const Regime regime = i < 6 ? Regime::straight : Regime::left;
        course.drive(regime);
        const WheelSpeed rim = v.interval.regimes[static_cast<std::size_t>(regime)].commanded;
        truth = truth * moved({0.9 * rim.left_mps * scan_s, 0.98 * rim.right_mps * scan_s, 0},
                              v.drive.track_width_m, calibration);
        // The mid-point of one long arc for that of many short ones.
        expect_same(course.wide.T_step_base_predicted(calibration), truth, 1e-6);
    }
}

TEST(WideInterval, without_re_prediction_the_first_speed_holds) {
    for (const auto control :
         {IntervalParameters::Control::measured, IntervalParameters::Control::commanded}) {
        Vehicle v;
        v.interval.control = control;
        v.interval.re_prediction = false;
        Course course(v);
        WideInterval& wide = course.wide;
        for (int i = 0; i < 20; ++i) course.drive(Regime::straight);
        wide.restart();
        for (int i = 0; i < 20; ++i) course.drive(i < 6 ? Regime::straight : Regime::left);
        EXPECT_EQ(wide.re_predictions(), 0);
        expect_same(v.predicted(wide), {20 * scan_s * straight_mps, 0, 0}, 1e-12);
    }
}

TEST(WideInterval, a_commanded_regime_in_the_log_is_believed) {
    Vehicle v;
    v.interval.control = IntervalParameters::Control::commanded;
    Course course(v);
    // What wheels that can't be measured might say.
    for (int i = 0; i < 20; ++i) course.add(v.motion(Regime::straight), Regime::right);
    expect_same(v.predicted(course.wide),
                moved({20 * scan_s * outer_mps, 20 * scan_s * inner_mps, 0}, v.drive.track_width_m), 1e-12);
}

TEST(WideInterval, noise_in_the_speeds_does_not_change_the_regime) {
    const Vehicle v;
    Course course(v);
    WideInterval& wide = course.wide;
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise(0, 1);
    for (int i = 0; i < 5000; ++i) {
        const Regime regime = i / 1000 % 2 == 0 ? Regime::straight : Regime::left;
        const WheelSpeed mean = v.interval.regimes[static_cast<std::size_t>(regime)].commanded;
        const WheelTravel travel{scan_s * (mean.left_mps + 0.003 * noise(random)),
                                 scan_s * (mean.right_mps + 0.003 * noise(random)), 0};
        if (course.add(moved(travel, v.drive.track_width_m))) wide.restart();
    }
    EXPECT_EQ(wide.re_predictions(), 4);
}

TEST(WideInterval, known_slip_shortens_the_travel_and_noise_is_of_the_regime) {
    Vehicle v;
    v.interval.regimes[1].slip_left = 0.5;
    v.interval.regimes[1].sigma_right_m = 0.2;
    Course course(v);
    WideInterval& wide = course.wide;
    for (int i = 0; i < 20; ++i) course.drive(Regime::left);
    ASSERT_EQ(wide.pieces().size(), 1u);
    const MotionPiece p = wide.pieces()[0];
    const double outer_m = 20 * scan_s * outer_mps;
    // One arc in place of twenty: their chords add up to a little less.
    EXPECT_NEAR(p.travel.left_m, 0.5 * 20 * scan_s * inner_mps, 2e-5);
    EXPECT_NEAR(p.travel.right_m, outer_m, 2e-5);
    EXPECT_NEAR(p.covariance(1, 1), 0.04 * outer_m + std::pow(v.drive.sigma_rest_m, 2), 1e-6);
}

TEST(WideInterval, what_the_control_was_is_split_like_the_prediction) {
    for (const auto control :
         {IntervalParameters::Control::measured, IntervalParameters::Control::commanded}) {
        Vehicle v;
        v.interval.control = control;
        v.interval.re_prediction = false;  // which is about predictions
        v.interval.regimes[1].slip_left = 0.5;
        Course course(v);
        for (int i = 0; i < 20; ++i) course.drive(Regime::straight);
        course.wide.restart();
        for (int i = 0; i < 20; ++i) course.drive(i < 6 || i >= 15 ? Regime::straight : Regime::left);
        const auto pieces = course.wide.drive_pieces();
        ASSERT_EQ(pieces.size(), 3u);
        EXPECT_EQ(pieces[0].regime, Regime::straight);
        EXPECT_EQ(pieces[1].regime, Regime::left);
        EXPECT_NEAR(pieces[1].duration_s, 9 * scan_s, 1e-12);
        EXPECT_NEAR(pieces[2].rolled.left_m, 5 * scan_s * straight_mps, 1e-9);
        EXPECT_NEAR(pieces[1].rolled.left_m, 9 * scan_s * inner_mps, 1e-5) << "whatever is known of slip";
        EXPECT_NEAR(pieces[1].rolled.right_m, 9 * scan_s * outer_mps, 1e-5);
    }
}

TEST(WideInterval, odometry_of_another_track_width_tells_the_same_ways) {
    Vehicle right, other;
    other.drive.track_width_m = 0.5;
    other.drive.odometry_track_width_m = right.drive.track_width_m;
    Course a(right), b(other);
    for (int i = 0; i < 20; ++i) {
        const Pose2 motion = right.motion(Regime::left);  // as the computer on board reckons it
        a.add(motion);
        b.add(motion);
    }
    const WheelTravel by_right = a.wide.drive_pieces()[0].rolled, by_other = b.wide.drive_pieces()[0].rolled;
    EXPECT_DOUBLE_EQ(by_right.left_m, by_other.left_m);
    EXPECT_DOUBLE_EQ(by_right.right_m, by_other.right_m);
    EXPECT_NEAR(other.predicted(b.wide).phi_rad, 0.4 / 0.5 * right.predicted(a.wide).phi_rad, 1e-12);
}

TEST(WideInterval, adaptive_steps_come_when_something_happens) {
    Vehicle v;
    v.interval.kind = IntervalParameters::Kind::adaptive;
    v.interval.scans = 100;
    v.interval.max_sigma_m = 1;
    v.interval.max_way_m = 0.2;
    v.interval.max_turn_rad = 0.1;
    const auto scans_until_due = [&](Regime regime, const IntervalParameters& interval) {
        Vehicle other = v;
        other.interval = interval;
        Course course(other);
        int scans = 1;
        while (!course.drive(regime)) ++scans;
        return scans;
    };
    EXPECT_EQ(scans_until_due(Regime::straight, v.interval),
              static_cast<int>(std::ceil(0.2 / (straight_mps * scan_s))));
    EXPECT_EQ(scans_until_due(Regime::left, v.interval),
              static_cast<int>(std::ceil(0.1 * 0.4 / ((outer_mps - inner_mps) * scan_s))));
    IntervalParameters careful = v.interval;
    careful.max_sigma_m = 0.005;
    EXPECT_LT(scans_until_due(Regime::straight, careful), 40);
    Course course(v);
    int scans = 1;
    while (!course.add(Pose2{})) ++scans;
    EXPECT_EQ(scans, 100);
}

}  // namespace
