/// Fusion of an odometry with GNSS: heading, consistency, and what becomes of bad fixes.
#include <gtest/gtest.h>

#include "support/fusion_drives.h"

using namespace loopline;
using namespace loopline::fusion;
using namespace loopline::fusion::test;

namespace {

TEST(EarthPath, heading_is_known_within_a_degree_after_20_m_wherever_the_vehicle_looks) {
    for (int k = 0; k < 12; ++k) {
        const Drive drive(8, (30 * k - 170) * rad);
        std::vector<std::optional<EarthState>> online;
        const EarthPath path = followed(drive, {}, static_cast<std::uint64_t>(k), {}, &online);
        ASSERT_TRUE(path.heading_known());
        EXPECT_LT(path.heading().way_m, 5);
        for (std::size_t i = 0; i < online.size(); ++i) {
            if ((drive.T_enu_base[i].translation_m - drive.T_enu_base[0].translation_m).norm() < 20) continue;
            ASSERT_TRUE(online[i]);
            const double off = online[i]->T_enu_base.yaw_rad() - drive.T_enu_base[i].yaw_rad();
            EXPECT_LT(std::abs(std::remainder(off, 2 * M_PI)), 1 * rad) << k;
        }
    }
}

// Mean of the normalised squares of 50 drives at four times, online and smoothed: 6 if all covariances are
// right.
void check_covariances_over_50_drives(const Receiver& receiver) {
    const EarthPathSettings settings = as_simulated(receiver);
    const Drive drive(60, 0.7);
    const std::size_t looks[] = {200, 350, 500, 590};
    double online_sum[4] = {}, smoothed_sum[4] = {};
    constexpr int runs = 50;
    for (std::uint64_t seed = 0; seed < runs; ++seed) {
        std::vector<std::optional<EarthState>> online;
        EarthPath path = followed(drive, receiver, seed, settings, &online);
        const Pose3 T = T_path_truth(path);
        const auto smoothed = path.finished();
        for (int i = 0; i < 4; ++i) {
            const Pose3 truth = T * drive.T_enu_base[looks[i]];
            online_sum[i] += nees(online[looks[i]]->T_enu_base, truth,
                                  online[looks[i]]->covariance.topLeftCorner<6, 6>()) /
                             runs;
            smoothed_sum[i] +=
                nees(smoothed[looks[i]].T_enu_base, truth, smoothed[looks[i]].covariance) / runs;
        }
    }
    // The mean of 50 draws of chi-square with 6 degrees of freedom lies within 4.5 .. 7.7 in 99.9 % of cases;
    // 3 mm of interpolation are claimed and not made.
    for (int i = 0; i < 4; ++i) {
        EXPECT_GT(online_sum[i], 4.2) << i;
        EXPECT_LT(online_sum[i], 7.7) << i;
        EXPECT_GT(smoothed_sum[i], 4.2) << i;
        EXPECT_LT(smoothed_sum[i], 7.7) << i;
    }
}

TEST(EarthPath, covariances_are_right_over_50_drives) {
    check_covariances_over_50_drives({});
}

TEST(EarthPath, covariances_are_right_over_50_drives_with_uncertain_stamps) {
    Receiver receiver;
    receiver.sigma_latency_s = 0.02;  // 0.16 m at 8 m/s
    check_covariances_over_50_drives(receiver);
}

TEST(EarthPath, multipath_is_refused_and_good_fixes_are_used) {
    Receiver receiver;
    receiver.jump_from_s = 20;
    receiver.jump_to_s = 26;
    receiver.jump_m = {9, -11, 4};
    std::vector<std::optional<EarthState>> online;
    const Drive drive(60, -2);
    EarthPath path = followed(drive, receiver, 1, {}, &online);
    EXPECT_NEAR(static_cast<double>(path.count(FixUse::off_the_path)), 30, 1);
    EXPECT_GT(path.count(FixUse::used), 260U);
    const Pose3 T = T_path_truth(path);
    for (std::size_t i = 150; i < online.size(); ++i)
        EXPECT_LT((online[i]->T_enu_base.translation_m - (T * drive.T_enu_base[i]).translation_m).norm(),
                  0.1);
}

TEST(EarthPath, an_outage_is_bridged_and_smoothed) {
    Receiver receiver;
    receiver.outage_from_s = 20;
    receiver.outage_to_s = 80;
    const Drive drive(110, 1);
    std::vector<std::optional<EarthState>> online;
    EarthPath path = followed(drive, receiver, 5, {}, &online);
    const Pose3 T = T_path_truth(path);
    const auto off_m = [&](const Pose3& pose, std::size_t i) {
        return (pose.translation_m - (T * drive.T_enu_base[i]).translation_m).norm();
    };
    EXPECT_LT(off_m(online[795]->T_enu_base, 795), 0.005 * 480) << "0.5 % of the way without fixes";
    const auto smoothed = path.finished();
    double online_worst_m = 0, smoothed_worst_m = 0;
    for (std::size_t i = 200; i < 800; ++i) {
        online_worst_m = std::max(online_worst_m, off_m(online[i]->T_enu_base, i));
        smoothed_worst_m = std::max(smoothed_worst_m, off_m(smoothed[i].T_enu_base, i));
    }
    EXPECT_LT(smoothed_worst_m, 0.7 * online_worst_m);
    EXPECT_EQ(path.re_entries(), 0U);
}

// Along a tunnel: what is missed across is a centimetre, and no reason to drive to and fro.
TEST(EarthPath, what_was_missed_along_a_free_direction_is_laid_out_along_the_way) {
    Receiver receiver;
    receiver.outage_from_s = 20;
    receiver.outage_to_s = 80;
    receiver.scale_in_outage = 1.03;
    receiver.free_in_outage_m = 10;
    Drive drive(110, 1);
    std::vector<Pose3> straight = {drive.T_enu_base.front()};
    for (std::size_t i = 1; i < drive.T_enu_base.size(); ++i) {  // straight on
        const double way_m =
            (drive.T_enu_base[i].translation_m - drive.T_enu_base[i - 1].translation_m).norm();
        straight.push_back(straight.back() * exp_se3({{way_m, 0, 0}, {0, 0, 0}}));
    }
    drive.T_enu_base = straight;
    constexpr std::uint64_t seeds = 5;
    double sum_m = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        EarthPath path = followed(drive, receiver, seed);
        const Pose3 T = T_path_truth(path);
        const auto smoothed = path.finished();
        double worst_m = 0;
        for (std::size_t i = 200; i < 800; ++i)
            worst_m = std::max(
                worst_m,
                (smoothed[i].T_enu_base.translation_m - (T * drive.T_enu_base[i]).translation_m).norm());
        sum_m += worst_m;
    }
    const double missed_m = 0.03 * 8 * 60;
    EXPECT_LT(sum_m / seeds, 0.05 * missed_m);
}

// A receiver that has just been switched on may tell where it was switched off.
TEST(EarthPath, a_first_fix_of_another_country_is_no_origin) {
    const Drive drive(30, 1);
    for (const double away_m : {50e3, 5e6}) {
        Receiver receiver;
        receiver.first_away_m = away_m;
        EarthPath path = followed(drive, receiver, 3);
        ASSERT_TRUE(path.heading_known());
        EXPECT_LT(path.earth()->p_enu_m(origin).norm(), 100);
        EXPECT_LE(path.count(FixUse::off_the_path), 4U);
        const Pose3 expected = T_path_truth(path) * drive.T_enu_base.back();
        EXPECT_LT((path.latest()->T_enu_base.translation_m - expected.translation_m).norm(), 0.1);
    }
}

TEST(EarthPath, a_fix_that_is_stamped_far_ahead_lets_the_others_pass) {
    const Drive drive(30, 1);
    const EarthPath undisturbed = followed(drive, {}, 3);
    for (const double ahead_s : {20.0, 1e5, 1024 * 604800.0}) {
        Receiver receiver;
        receiver.first_ahead_s = ahead_s;
        EarthPath path = followed(drive, receiver, 3);
        EXPECT_GE(path.count(FixUse::used) + 4, undisturbed.count(FixUse::used)) << ahead_s;
        path.finished();
        EXPECT_LE(path.count(FixUse::late), 2U) << "which came after one of its own time had been used";
    }
}

// 2 % of the way are far more than what the odometry says of itself.
TEST(EarthPath, finds_back_within_seconds_after_an_outage_that_the_odometry_did_not_bridge) {
    Receiver receiver;
    receiver.outage_from_s = 20;
    receiver.outage_to_s = 80;
    receiver.scale_in_outage = 1.02;
    const Drive drive(110, 1);
    EarthPath path = followed(drive, receiver, 5);
    EXPECT_EQ(path.re_entries(), 1U);
    EXPECT_LE(path.count(FixUse::off_the_path), 20U);
    EXPECT_LT((path.latest()->T_enu_base.translation_m -
               (T_path_truth(path) * drive.T_enu_base.back()).translation_m)
                  .norm(),
              0.1);
}

// An odometry that jumps where it says it does not: all fixes are off from then on, and right.
TEST(EarthPath, finds_back_when_it_is_the_estimate_that_is_wrong) {
    const Drive drive(120, 0.3);
    Receiver receiver;
    receiver.jump_from_s = 40;
    receiver.jump_to_s = 1e9;
    receiver.jump_m = {3, 4, 0};
    EarthPath path = followed(drive, receiver, 2);
    EXPECT_EQ(path.re_entries(), 1U);
    EXPECT_NEAR(static_cast<double>(path.count(FixUse::off_the_path)), 150, 10);
    const Eigen::Vector3d end_m = path.latest()->T_enu_base.translation_m -
                                  (T_path_truth(path) * drive.T_enu_base.back()).translation_m;
    EXPECT_LT((end_m - receiver.jump_m).norm(), 0.2);
}

TEST(EarthPath, every_fix_is_counted_once_with_what_became_of_it) {
    Receiver receiver;
    receiver.outage_from_s = 3;
    receiver.outage_to_s = 9;
    receiver.jump_from_s = 20;
    receiver.jump_to_s = 22;
    receiver.jump_m = {9, -11, 4};
    for (const double seconds : {1.0, 30.0}) {  // of which the first tell no heading
        const Drive drive(seconds, 1);
        EarthPath path = followed(drive, receiver, 1);
        std::size_t given = 0;
        for (StampNs fix_ns = second / 17 + second * 15 / 100; fix_ns <= std::llround(1e9 * seconds);
             fix_ns += second / 5)
            ++given;
        gnss::GnssFix odd;
        odd.quality = gnss::FixQuality::single;
        odd.has_position = true;
        odd.antenna = origin;
        for (const StampNs stamp_ns : {drive.stamps_ns.front() - second, drive.stamps_ns.back() + second}) {
            odd.stamp_ns = stamp_ns;
            path.take_fix(odd);
        }
        path.take_fix({});
        const auto smoothed = path.finished();
        EXPECT_EQ(smoothed.size(), drive.stamps_ns.size());
        EXPECT_EQ(path.poses(), drive.stamps_ns.size());
        std::size_t counted = 0;
        for (std::size_t use = 0; use < fix_uses; ++use) counted += path.count(static_cast<FixUse>(use));
        EXPECT_EQ(counted, given + 3);
        EXPECT_EQ(path.count(FixUse::before_path), 1U);
        EXPECT_EQ(path.count(FixUse::after_path), 1U);
        EXPECT_EQ(path.heading_known(), seconds > 10);
    }
}

// What is known before the first fix is that the receiver has said nothing: no number may come from anywhere
// else.
TEST(EarthPath, a_receiver_that_starts_late_places_the_way_before_too) {
    Receiver receiver;
    receiver.outage_from_s = 0;
    receiver.outage_to_s = 15;
    const Drive drive(40, 2);
    EarthPath path = followed(drive, receiver, 4);
    const Pose3 T = T_path_truth(path);
    const auto smoothed = path.finished();
    for (std::size_t i = 0; i < smoothed.size(); ++i) {
        ASSERT_TRUE(smoothed[i].covariance.allFinite());
        EXPECT_LT((smoothed[i].T_enu_base.translation_m - (T * drive.T_enu_base[i]).translation_m).norm(),
                  0.5);
    }
}

TEST(EarthPath, slow_errors_of_single_fixes_are_not_averaged_away) {
    Receiver receiver;
    receiver.quality = gnss::FixQuality::single;
    receiver.white_m = 0.4;
    receiver.correlated_m = 2;
    receiver.correlation_s = 45;
    const Drive drive(120, 0.3);
    double squares = 0, claimed = 0;
    int known = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        EarthPath path = followed(drive, receiver, seed);
        if (!path.heading_known()) continue;
        ++known;
        const EarthState end = *path.latest();
        const Eigen::Vector3d off_m =
            end.T_enu_base.translation_m - (T_path_truth(path) * drive.T_enu_base.back()).translation_m;
        squares += off_m.head<2>().squaredNorm();
        claimed += end.covariance(0, 0) + end.covariance(1, 1);
    }
    EXPECT_GE(known, 18);
    EXPECT_LT(squares, 2.5 * claimed);
    EXPECT_GT(squares, 0.4 * claimed);
}

// The antenna is not where the log says: turning tells.
/// A hill side that leans by 2 degrees: along the street nothing tells so, and fixes end before the corner.
TEST(EarthPath, knows_by_what_is_upright_how_far_it_leans) {
    Drive drive(30, 0.5);
    Pose3 T{{0, 0, 0}, inertial::exp_so3({0, 0, 0.5}) * inertial::exp_so3({2 * rad, 0, 0})};
    for (std::size_t k = 0; k < drive.T_enu_base.size(); ++k) {
        drive.T_enu_base[k] = T;
        const double turn_rad = k > 150 && k < 170 ? M_PI / 2 / 19 : 0;
        T = T * exp_se3({{k > 20 ? 0.8 : 0, 0, 0}, {0, 0, turn_rad}});
    }
    const gnss::LocalFrame frame(origin);
    std::mt19937_64 random(20);
    const auto height_error_m = [&](bool upright_told, double upright_errs_rad) {
        EarthPath path{EarthPathSettings{}};
        const Pose3 T_odom_enu = drive.T_enu_base.front().inverse();
        for (std::size_t k = 0; k < drive.T_enu_base.size(); ++k) {
            if (upright_told && k == 80)
                path.take_upright(
                    {inertial::exp_so3({upright_errs_rad, 0, 0}) * T_odom_enu.rotation.conjugate(),
                     1e-6 * Eigen::Matrix2d::Identity()});
            const Matrix6d covariance = k > 20 ? Matrix6d(1e-8 * Matrix6d::Identity()) : Matrix6d::Zero();
            path.take_pose(drive.stamps_ns[k], T_odom_enu * drive.T_enu_base[k], covariance);
            if (k % 2 == 1 || k > 140) continue;
            gnss::GnssFix fix;
            fix.stamp_ns = drive.stamps_ns[k];
            fix.quality = gnss::FixQuality::rtk_fixed;
            fix.has_position = fix.has_height = true;
            fix.p_base_antenna_m = p_base_antenna_m;
            fix.antenna = frame.geodetic(drive.T_enu_base[k] * p_base_antenna_m + drawn(random, 0.01));
            path.take_fix(fix);
        }
        const Pose3 truth = T_path_truth(path) * drive.T_enu_base.back();
        const double error_m = path.known()->T_enu_base.translation_m.z() - truth.translation_m.z(),
                     sigma_m = std::sqrt(path.known()->covariance(2, 2));
        EXPECT_LT(std::abs(error_m), 3 * sigma_m);
        return std::abs(error_m);
    };
    EXPECT_GT(height_error_m(false, 0), 1);
    EXPECT_LT(height_error_m(true, 0.2 * rad), 0.5);
    // So far no vehicle leans: something else was taken for walls.
    EXPECT_GT(height_error_m(true, 15 * rad), 1);
}

TEST(EarthPath, finds_where_the_antenna_is) {
    EarthPathSettings settings;
    settings.sigma_antenna_m = 2;
    const Eigen::Vector3d off_m(1.5, -0.7, 0);
    const Drive drive(90, 0.7);
    EarthPath path = followed(drive, {}, 6, settings, nullptr, std::nullopt, 1e9, 1e9, off_m);
    EXPECT_LT((path.antenna_off_m() - off_m).norm(), 0.1);
    EXPECT_LT((path.latest()->T_enu_base.translation_m -
               (T_path_truth(path) * drive.T_enu_base.back()).translation_m)
                  .norm(),
              0.2);
}

}  // namespace
