/// Fusion with wheels: their lasting errors, slip, what they bridge; gaps cut out on purpose.
#include <gtest/gtest.h>

#include "api/dense_algebra.h"
#include "support/fusion_drives.h"

using namespace loopline;
using namespace loopline::fusion;
using namespace loopline::fusion::test;

namespace {

// An odometry that sees nothing along a tunnel, and wheels whose scale nobody knew: found before it.
TEST(EarthPath, wheels_whose_scale_was_found_lead_where_the_odometry_is_blind) {
    Receiver receiver;
    receiver.outage_from_s = 50;
    receiver.outage_to_s = 110;
    Wheels wheels;
    wheels.odometry_is_blind = true;
    const Drive drive(125, 1);
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        std::vector<std::optional<EarthState>> online;
        EarthPath path = followed(drive, receiver, seed, {}, &online, wheels);
        const Eigen::Vector3d at_exit_m = online[1099]->T_enu_base.translation_m -
                                          (T_path_truth(path) * drive.T_enu_base[1099]).translation_m;
        EXPECT_LT(at_exit_m.norm(), 0.005 * 480) << "0.5 % of the way without fixes";
        EXPECT_NEAR(path.wheel_errors()[way_scale], wheels.errors[way_scale], 0.002);
        EXPECT_NEAR(path.wheel_errors()[bend], wheels.errors[bend], 0.02 * rad);
        EXPECT_EQ(path.wheel_use().slipped, 0U);
        EXPECT_EQ(path.re_entries(), 0U);
        EXPECT_LE(path.count(FixUse::off_the_path), 2U) << "one in a thousand is";
    }
}

TEST(EarthPath, wheels_that_slip_are_noticed_and_do_not_count) {
    Wheels wheels;
    wheels.slip_from_s = 20.05;
    wheels.slip_to_s = 22.05;
    const Drive drive(60, -1);
    std::vector<std::optional<EarthState>> online;
    EarthPath path = followed(drive, {}, 3, {}, &online, wheels);
    EXPECT_EQ(path.wheel_use().slipped, 20U);
    EXPECT_EQ(path.wheel_use().used, drive.stamps_ns.size() - 1 - 20);
    EXPECT_NEAR(path.wheel_errors()[way_scale], wheels.errors[way_scale], 0.002);
    const Pose3 T = T_path_truth(path);
    for (std::size_t i = 150; i < online.size(); ++i)
        EXPECT_LT((online[i]->T_enu_base.translation_m - (T * drive.T_enu_base[i]).translation_m).norm(),
                  0.1);
}

// Where the odometry is uncertain it may have its way from the wheels; if these have slipped, it still knows
// what it claims.
TEST(EarthPath, wheels_that_slip_leave_the_word_of_an_odometry_that_is_uncertain) {
    EarthPath path({});
    Matrix6d covariance = 1e-6 * Matrix6d::Identity();
    covariance(0, 0) = 0.05 * 0.05;
    const Twist2 told{0.8, 0, 0.3};  // a turn that was not made
    for (int k = 0; k <= 20; ++k)
        path.take_pose(k * second / 10, Pose3(Pose2{0.8 * k, 0, 0}), covariance, told);
    EXPECT_EQ(path.wheel_use().slipped, 20U);
    const Motion& motion = path.latest_motion();
    EXPECT_NEAR(motion.T_from_to.translation_m.x(), 0.8, 1e-9);
    EXPECT_NEAR(std::sqrt(motion.covariance(0, 0)), 0.05, 0.001);
}

// For seconds on ice, with nothing beside them that tells: fixes that begin to depart are right.
TEST(EarthPath, wheels_alone_that_slip_are_set_right_within_seconds) {
    const Drive drive(110, 1);
    Wheels wheels;
    wheels.alone = true;
    for (const double slip_s : {1.5, 3.0, 6.0}) {
        wheels.slip_from_s = 50;
        wheels.slip_to_s = 50 + slip_s;
        EarthPath path = followed(drive, {}, 4, {}, nullptr, wheels);
        EXPECT_GE(path.re_entries(), 1U) << slip_s;
        EXPECT_LT(path.count(FixUse::off_the_path), 90U) << slip_s;
        EXPECT_LT((path.latest()->T_enu_base.translation_m -
                   (T_path_truth(path) * drive.T_enu_base.back()).translation_m)
                      .norm(),
                  0.15)
            << slip_s;
    }
}

// 50 drives by wheels alone: their three errors and the pose, with the covariance that they claim.
TEST(EarthPath, wheels_alone_find_their_errors) {
    const Receiver receiver;
    EarthPathSettings settings = as_simulated(receiver);
    settings.wheels.along_m = settings.wheels.across_m = 0.01;
    settings.wheels.turn_rad = 0.05 * rad;
    settings.wheels.turn_per_turn_rad = 0;
    settings.wheels.drift_km.setZero();
    settings.wheels.first.tail<2>().setZero();
    const Drive drive(60, 0.7);
    constexpr int runs = 50;
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    double horizontal = 0;
    for (std::uint64_t seed = 0; seed < runs; ++seed) {
        std::mt19937_64 random(1000 + seed);
        Wheels wheels;
        wheels.alone = true;
        wheels.errors.head<3>() = drawn(random, 1).cwiseProduct(settings.wheels.first.head<3>());
        EarthPath path = followed(drive, receiver, seed, settings, nullptr, wheels);
        ASSERT_TRUE(path.heading_known());
        const WheelErrors off = path.wheel_errors() - wheels.errors, sigma = path.wheel_error_sigmas();
        squares += off.head<3>().cwiseQuotient(sigma.head<3>()).cwiseAbs2() / runs;
        const EarthState end = *path.latest();
        const Eigen::Vector2d off_m =
            (end.T_enu_base.translation_m - (T_path_truth(path) * drive.T_enu_base.back()).translation_m)
                .head<2>();
        horizontal += squared_in_sigmas(off_m, end.covariance.topLeftCorner<2, 2>()) / runs;
    }
    // Mean of 50 draws of chi-square with 1 and with 2 degrees of freedom, 99.9 %: 0.44 .. 1.8, 1.2 .. 3.1.
    // The drive climbs and falls, which the noise out of the plane covers.
    for (int k = 0; k < 3; ++k) {
        EXPECT_GT(squares[k], 0.35) << k;
        EXPECT_LT(squares[k], 1.9) << k;
    }
    EXPECT_GT(horizontal, 0.8);
    EXPECT_LT(horizontal, 3.2);
}

TEST(EarthPath, gaps_tell_how_far_the_path_went_astray_within_them) {
    const Drive drive(60, 0.7);
    Wheels wheels;
    wheels.alone = true;
    std::vector<std::optional<EarthState>> online;
    EarthPath path = followed(drive, {}, 6, {}, &online, wheels, 30, 50);
    const Pose3 T = T_path_truth(path);
    const auto smoothed = path.finished();
    ASSERT_EQ(path.gaps().size(), 1U);
    const Gap& gap = path.gaps().front();
    EXPECT_NEAR(seconds_between(drive.stamps_ns.front(), gap.from_ns), 30, 0.3);
    EXPECT_NEAR(seconds_between(drive.stamps_ns.front(), gap.to_ns), 50, 0.3);
    EXPECT_NEAR(gap.way_m, 8 * seconds_between(gap.from_ns, gap.to_ns) / 1.02, 1) << "as the wheels have it";
    EXPECT_NEAR(static_cast<double>(path.count(FixUse::withheld)), 100, 1);
    const Eigen::Vector3d truth_m = (T * drive.T_enu_base[gap.end_pose]).translation_m;
    EXPECT_NEAR((gap.off_m - (gap.end_m - truth_m)).norm(), 0, 0.1) << "as good as with the truth";
    EXPECT_LT(gap.off_m.head<2>().norm(), 4 * gap.sigma_m.head<2>().norm());
    EXPECT_GT(gap.dead_reckoning_off_m.head<2>().norm(), 5 * gap.off_m.head<2>().norm());
    // Without fixes after it a gap can't be judged.
    EarthPath open = followed(drive, {}, 6, {}, nullptr, wheels, 30);
    open.finished();
    EXPECT_TRUE(open.gaps().empty());
}

}  // namespace
