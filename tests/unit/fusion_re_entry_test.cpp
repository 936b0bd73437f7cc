/// Fixes that lie: where a path begins by them, and when it is believed against them, or they against it.
#include <gtest/gtest.h>

#include <algorithm>

#include "fusion/re_entry.h"
#include "support/fusion_drives.h"

using namespace loopline;
using namespace loopline::fusion;
using namespace loopline::fusion::test;

namespace {

Eigen::Vector3d off_at_the_end_m(const EarthPath& path, const Drive& drive) {
    return path.latest()->T_enu_base.translation_m -
           (T_path_truth(path) * drive.T_enu_base.back()).translation_m;
}

TEST(EarthPath, a_start_in_reflected_signals_is_left_behind) {
    const Drive drive(60, 0.4);
    Receiver receiver;
    receiver.jump_from_s = 0;
    receiver.jump_to_s = 9;
    receiver.jump_m = {3, 4, -2};
    // The frame's origin is the first fix, which is reflected: the truth lies as far off in it.
    EarthPath path = followed(drive, receiver, 3);
    EXPECT_EQ(path.re_entries(), 1U);
    EXPECT_LT(off_at_the_end_m(path, drive).norm(), 0.1);
    EXPECT_GT(path.count(FixUse::used), 160U) << "of some 250 good ones";
    const auto smoothed = path.finished();
    const Pose3 T = T_path_truth(path);
    for (std::size_t i = 0; i < smoothed.size(); i += 20)
        EXPECT_LT((smoothed[i].T_enu_base.translation_m - (T * drive.T_enu_base[i]).translation_m).norm(),
                  0.15)
            << i;
}

TEST(EarthPath, reflected_signals_after_an_outage_are_not_believed) {
    const Drive drive(110, -1);
    Receiver receiver;
    receiver.outage_from_s = 20;
    receiver.outage_to_s = 60;
    receiver.jump_from_s = 60;
    receiver.jump_to_s = 70;
    receiver.jump_m = {25, -15, 10};
    EarthPath path = followed(drive, receiver, 4);
    EXPECT_EQ(path.re_entries(), 0U);
    EXPECT_NEAR(static_cast<double>(path.count(FixUse::off_the_path)), 50, 1);
    EXPECT_LT(off_at_the_end_m(path, drive).norm(), 0.1);
}

// They last until they are believed; but then the way since the outage began leads to the good ones.
TEST(EarthPath, reflected_signals_that_were_believed_are_undone_by_good_ones_that_the_motion_explains) {
    const Drive drive(130, 2);
    Receiver receiver;
    receiver.outage_from_s = 25;
    receiver.outage_to_s = 45;
    receiver.jump_from_s = 45;
    receiver.jump_to_s = 80;
    receiver.jump_m = {9, -12, 5};
    std::vector<std::optional<EarthState>> online;
    EarthPath path = followed(drive, receiver, 4, {}, &online);
    const Pose3 T = T_path_truth(path);
    const auto off_m = [&](const Pose3& T_enu_base, std::size_t k) {
        return (T_enu_base.translation_m - (T * drive.T_enu_base[k]).translation_m).norm();
    };
    EXPECT_GT(off_m(online[790]->T_enu_base, 790), 10) << "nothing told that they were reflected";
    EXPECT_LT(off_m(online[840]->T_enu_base, 840), 0.2);
    EXPECT_GT(path.count(FixUse::used), 360U) << "of some 375 good ones";
    const auto smoothed = path.finished();
    for (std::size_t k = 0; k < smoothed.size(); k += 20)
        EXPECT_LT(off_m(smoothed[k].T_enu_base, k), 0.3) << k;
}

// The good ones come after an outage, and at first for a shorter time than the reflected ones did: it could
// be drift. But drift does not come to so much.
TEST(EarthPath, a_start_in_reflected_signals_is_undone_when_good_ones_have_come_for_longer) {
    const Drive drive(110, 0.7);
    Receiver receiver;
    receiver.jump_from_s = 0;
    receiver.jump_to_s = 20;
    receiver.jump_m = {4, -7, 2};
    receiver.outage_from_s = 20;
    receiver.outage_to_s = 52;
    EarthPath path = followed(drive, receiver, 5);
    const auto smoothed = path.finished();
    const Pose3 T = T_path_truth(path);
    for (std::size_t k = 0; k < smoothed.size(); k += 20) {
        const Eigen::Vector3d off_m =
            smoothed[k].T_enu_base.translation_m - (T * drive.T_enu_base[k]).translation_m;
        EXPECT_LT(off_m.norm(), 1) << k;
        EXPECT_LT(squared_in_sigmas(off_m, smoothed[k].covariance.topLeftCorner<3, 3>()), 16) << k;
    }
    EXPECT_EQ(path.re_entries(), 2U);
    EXPECT_NEAR(static_cast<double>(path.count(FixUse::used)), 290, 10);
    EXPECT_NEAR(static_cast<double>(path.count(FixUse::off_the_path)), 100, 10);
}

// Good fixes depart from it little by little: no reflection does that.
TEST(EarthPath, an_odometry_that_leans_without_telling_is_set_right_within_seconds) {
    const Drive drive(70, 0.7);
    Receiver receiver;
    receiver.leans_at_s = 30;
    receiver.lean_rad = 0.3 * rad;
    EarthPath path = followed(drive, receiver, 6);
    EXPECT_LT(path.count(FixUse::off_the_path), 50U);
    EXPECT_LT(off_at_the_end_m(path, drive).norm(), 0.1);
    const auto smoothed = path.finished();
    const Pose3 T = T_path_truth(path);
    for (std::size_t k = 0; k < smoothed.size(); k += 10)
        EXPECT_LT((smoothed[k].T_enu_base.translation_m - (T * drive.T_enu_base[k]).translation_m).norm(),
                  0.2)
            << k;
}

// Fixes at 5 Hz from a vehicle at 5 m/s, off by `off_m` for `duration_s`: at which one they are believed.
struct Fixes {
    ReEntry re_entry;
    double time_s = 0;

    bool come(double duration_s, const Eigen::Vector3d& off_m, double sigma_m = 0.01) {
        for (const double end_s = time_s + duration_s; time_s < end_s - 0.1; time_s += 0.2) {
            const ReEntry::Fix fix{std::llround(1e9 * time_s), 5 * time_s, sigma_m, sigma_m};
            if (off_m.isZero())
                re_entry.used(fix, 30);
            else if (re_entry.refused(fix, off_m, 30) != ReEntry::Verdict::path_holds)
                return true;
        }
        return false;
    }
};

TEST(ReEntry, the_place_that_most_fixes_speak_for_is_believed_though_half_of_them_are_reflected) {
    const Eigen::Vector3d good_m(-1.7, 2.2, -4.2);  // from where the path began, by reflected ones
    Fixes fixes;
    fixes.re_entry.begin(0, 0);
    EXPECT_FALSE(fixes.come(4, {0, 0, 0}));
    EXPECT_FALSE(fixes.come(6, good_m));
    EXPECT_FALSE(fixes.come(7, {-1, -3.4, -7.4}));
    EXPECT_FALSE(fixes.come(3, good_m));
    EXPECT_FALSE(fixes.come(4, {2.1, 0.8, 1.5}));
    EXPECT_TRUE(fixes.come(8, good_m));
}

TEST(ReEntry, a_path_is_believed_the_longer_the_more_fixes_it_rests_on) {
    for (const double rests_on_s : {3.0, 10.0, 60.0}) {
        Fixes fixes;
        fixes.re_entry.begin(0, 0);
        EXPECT_FALSE(fixes.come(rests_on_s, {0, 0, 0}));
        const double from_s = fixes.time_s;
        EXPECT_TRUE(fixes.come(60, {4, 3, 0}));
        EXPECT_NEAR(fixes.time_s - from_s, std::clamp(2 * rests_on_s, 15.0, 30.0), 0.7);
    }
}

TEST(ReEntry, fixes_that_depart_little_by_little_are_believed_within_seconds_and_those_that_jump_are_not) {
    const auto believed_after_s = [](double jump_m, double per_s_m) {
        Fixes fixes;
        fixes.re_entry.begin(0, 0);
        fixes.come(20, {0, 0, 0});
        for (double s = 0.2; s < 14; s += 0.2)
            if (fixes.come(0.2, {0, 0, jump_m + per_s_m * s})) return s;
        return 1e9;
    };
    EXPECT_LT(believed_after_s(0.03, 0.05), 4);
    EXPECT_EQ(believed_after_s(0.4, 0), 1e9);
    EXPECT_EQ(believed_after_s(0.4, 0.05), 1e9);
    EXPECT_EQ(believed_after_s(0.03, 0.5), 1e9) << "no path drifts by a tenth of its way";
}

TEST(ReEntry, fixes_of_a_vehicle_that_stands_tell_nothing_new) {
    ReEntry re_entry;
    re_entry.begin(0, 0);
    re_entry.used({second, 20, 0.01, 0.01}, 30);
    for (int k = 0; k < 500; ++k)
        EXPECT_EQ(re_entry.refused({2 * second + k * second / 5, 20, 0.01, 0.01}, {4, 3, 0}, 30),
                  ReEntry::Verdict::path_holds)
            << k;
}

TEST(FindHeading, leaves_out_what_was_reflected) {
    std::mt19937_64 random(7);
    const Eigen::AngleAxisd turned(1.1, Eigen::Vector3d::UnitZ());
    std::vector<SeenFix> fixes;
    std::vector<bool> good;
    for (int k = 0; k < 40; ++k) {
        SeenFix fix;
        fix.time_s = 0.4 * k;
        fix.p_local_m = {1.0 * k, 4 * std::sin(0.1 * k), 0};
        fix.sigma = {{0.01, 0.01, 0.02}, {0.004, 0.004, 0.008}, 60};
        Eigen::Vector3d jump_m(0, 0, 0);
        if (k >= 5 && k < 12) jump_m = {7, -2, 1};
        if (k >= 25 && k < 32) jump_m = {-3, 6, 2};
        fix.p_enu_m = Eigen::Vector3d(100, 50, 3) + turned * fix.p_local_m + drawn(random, 0.01) + jump_m;
        fixes.push_back(fix);
        good.push_back(jump_m.isZero());
    }
    const std::vector<SeenFix> found = agreeing(fixes);
    ASSERT_EQ(static_cast<std::ptrdiff_t>(found.size()), std::count(good.begin(), good.end(), true));
    std::size_t next = 0;
    for (std::size_t k = 0; k < fixes.size(); ++k)
        if (good[k]) {
            EXPECT_EQ(found[next++].time_s, fixes[k].time_s);
        }
    const auto heading = find_heading(found);
    ASSERT_TRUE(heading);
    EXPECT_NEAR(heading->T_enu_local.yaw_rad(), 1.1, 3 * heading->sigma_rad);
    EXPECT_LT(heading->sigma_rad, 0.1 * rad);
    EXPECT_LT(heading->misfit, 2);
}

}  // namespace
