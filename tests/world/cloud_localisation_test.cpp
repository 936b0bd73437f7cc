/// Drives through a yard whose cloud is finished: the start by a fix, errors and what is claimed of them,
/// lost and found again, and fixes that contradict.

#include "api/dense_algebra.h"
#include "cloud_localisation/localised_path.h"
#include "inertial/rotation_vector.h"
#include "support/cloud_in_yard.h"

using namespace loopline;
using namespace loopline::cloud_localisation;
using namespace loopline::test;

namespace {

constexpr double sweep_s = 0.1;

/// A circle through the yard at 4 m/s.
struct Drive {
    Twist3 velocity{{4, 0, 0}, {0, 0, 0.4}};
    Pose3 at(int sweep) const { return level_pose(2, -11, 0) * exp_se3(velocity * (sweep * sweep_s)); }
};

StampNs stamp_of(int sweep) {
    return 1'600'000'000 * second_ns + sweep * second_ns / 10;
}

const std::vector<Rectangle>& yard() {
    static const std::vector<Rectangle> world = in_map(walled_yard());
    return world;
}
const FrozenCloud& yard_map() {
    static const FrozenCloud map = cloud_of(yard());
    return map;
}

}  // namespace

TEST(CloudLocalisation, begins_at_a_fix_and_claims_what_it_errs_by) {
    constexpr int runs = 8, sweeps = 7;
    LocalisationSettings settings;
    settings.sigma_map_m = 0.03;
    settings.sigma_map_rad = 0.1 * M_PI / 180;
    const Drive drive;
    double sum = 0;
    for (int run = 0; run < runs; ++run) {
        SCOPED_TRACE(run);
        std::mt19937_64 random(static_cast<std::uint64_t>(run));
        std::normal_distribution<double> normal;
        CloudLocalisation localisation(settings, yard_map(), 1);
        // A map that errs as a whole is, for the vehicle, a truth that is elsewhere.
        const auto draw = [&](double sigma) {
            const double x = normal(random), y = normal(random), z = normal(random);
            return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
        };
        const Eigen::Vector3d shift_m = draw(settings.sigma_map_m), turn_rad = draw(settings.sigma_map_rad);
        const Eigen::Vector3d fix_m = draw(1.5);
        LocalisedSweep latest;
        const int first = 7 * run;
        for (int k = first; k < first + sweeps; ++k) {
            if (k == first) localisation.take_fix(fix_of(drive.at(k), stamp_of(k), 2, fix_m));
            latest = localisation.add(sweep_at(yard(), drive.at(k), drive.velocity, stamp_of(k), random));
        }
        ASSERT_TRUE(latest.known) << localisation.latest_look().reason;
        const Pose3 truth = drive.at(first + sweeps - 1);
        Eigen::Matrix<double, 6, 1> e;
        e << latest.T_map_base.translation_m - truth.translation_m - shift_m,
            inertial::log_so3(latest.T_map_base.rotation * truth.rotation.conjugate()) - turn_rad;
        sum += squared_in_sigmas(e, latest.covariance);
        EXPECT_LT((latest.T_map_base.translation_m - truth.translation_m).norm(), 0.02);
    }
    // 95 % of a chi-square of 48 degrees of freedom, by 8.
    EXPECT_GT(sum / runs, 3.84);
    EXPECT_LT(sum / runs, 8.63);
}

TEST(CloudLocalisation, claims_what_noise_makes_where_the_map_is_right) {
    constexpr int runs = 5, sweeps = 8;
    LocalisationSettings settings;
    settings.sigma_map_m = settings.sigma_map_rad = 0;
    const Drive drive;
    double sum = 0;
    for (int run = 0; run < runs; ++run) {
        std::mt19937_64 random(static_cast<std::uint64_t>(100 + run));
        settings.T_map_start = drive.at(9 * run) * Pose3(Pose2{0.4, -0.3, 0.05});
        CloudLocalisation localisation(settings, yard_map(), 1);
        LocalisedSweep latest;
        for (int k = 9 * run; k < 9 * run + sweeps; ++k)
            latest = localisation.add(sweep_at(yard(), drive.at(k), drive.velocity, stamp_of(k), random));
        ASSERT_TRUE(latest.known) << localisation.latest_look().reason;
        const Pose3 truth = drive.at(9 * run + sweeps - 1);
        Eigen::Matrix<double, 6, 1> e;
        e << latest.T_map_base.translation_m - truth.translation_m,
            inertial::log_so3(latest.T_map_base.rotation * truth.rotation.conjugate());
        sum += squared_in_sigmas(e, latest.covariance);
    }
    // The map's own noise is common to the sweeps of a place, which sigma_map_* is for: more than 6, not
    // much.
    EXPECT_GT(sum / runs, 2);
    EXPECT_LT(sum / runs, 14);
}

TEST(CloudLocalisation, lays_out_backwards_what_came_before_the_start) {
    const Drive drive;
    std::mt19937_64 random(4);
    CloudLocalisation localisation({}, yard_map(), 1);
    LocalisedPath path;
    constexpr int late = 6, sweeps = 14;
    for (int k = 0; k < sweeps; ++k) {
        if (k == late) localisation.take_fix(fix_of(drive.at(k), stamp_of(k), 0.3));
        path.add(static_cast<std::uint64_t>(k), stamp_of(k),
                 localisation.add(sweep_at(yard(), drive.at(k), drive.velocity, stamp_of(k), random)));
    }
    Trajectory trajectory;
    path.lay_out(trajectory);
    ASSERT_EQ(trajectory.size(), static_cast<std::size_t>(sweeps));
    EXPECT_GT(trajectory.known_from(), static_cast<std::size_t>(late)) << "one look is not enough";
    EXPECT_EQ(path.without_place(), 0U);
    for (int k = 0; k < sweeps; ++k) {
        const auto entry = trajectory[static_cast<std::size_t>(k)];
        EXPECT_LT((entry.T_map_base.translation_m - drive.at(k).translation_m).norm(), 0.06) << k;
        EXPECT_GT(entry.covariance.matrix().diagonal().minCoeff(), 0);
    }
}

TEST(CloudLocalisation, says_that_it_is_lost_and_finds_itself_again) {
    const auto elsewhere = endless_corridor();
    const Drive drive;
    std::mt19937_64 random(8);
    LocalisationSettings settings;
    settings.T_map_start = drive.at(0);
    settings.lost_after_s = 0.5;
    CloudLocalisation localisation(settings, yard_map(), 1);
    LocalisedPath path;
    constexpr int away = 10, back = 20, sweeps = 45;
    int unknown = 0;
    for (int k = 0; k < sweeps; ++k) {
        const bool is_away = k >= away && k < back;
        localisation.take_fix(fix_of(drive.at(k), stamp_of(k), 1));
        const auto sweep = localisation.add(
            sweep_at(is_away ? elsewhere : yard(), drive.at(k), drive.velocity, stamp_of(k), random));
        path.add(static_cast<std::uint64_t>(k), stamp_of(k), sweep);
        if (!is_away && sweep.known) {
            EXPECT_LT((sweep.T_map_base.translation_m - drive.at(k).translation_m).norm(), 0.05) << k;
        }
        unknown += is_away && !sweep.known ? 1 : 0;
        if (k == sweeps - 1) {
            EXPECT_TRUE(sweep.known) << localisation.latest_look().reason;
        }
    }
    EXPECT_GE(unknown, 4);
    EXPECT_EQ(localisation.counts().lost, 1);
    EXPECT_EQ(localisation.counts().starts, 2);
    ASSERT_EQ(path.lost().size(), 2U) << "the start, and once";
    EXPECT_TRUE(path.lost()[1].found);
}

/// In the middle of a tunnel nothing that a lidar sees tells how far it has come: the place must get lost
/// there, but not how fast the vehicle is; and the way through must be as uncertain as it claims.
TEST(CloudLocalisation, gives_up_in_a_tunnel_and_knows_how_fast_it_went_through) {
    std::vector<Rectangle> tunnel{{{-60, -25, 0}, {250, 0, 0}, {0, 50, 0}},
                                  {{0, -4, 0}, {110, 0, 0}, {0, 0, 4}},
                                  {{0, 4, 0}, {110, 0, 0}, {0, 0, 4}}};
    // Houses before and behind it.
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> side_m(2, 7);
    for (const double begin_m : {-52.0, 114.0})
        for (double x_m = begin_m; x_m < begin_m + 45; x_m += 9)
            for (const double y_m : {-14.0, 8.0}) {
                const double length_m = side_m(random), width_m = side_m(random), back_m = side_m(random);
                add_box(tunnel, x_m, y_m + (y_m > 0 ? back_m : -back_m), length_m, width_m, 5);
            }
    tunnel = in_map(tunnel);
    const FrozenCloud map = cloud_of(tunnel);
    const Twist3 velocity{{8, 0, 0}, {0, 0, 0}};
    const auto at = [&](int sweep) {
        return level_pose(-20, 0.4, 0) * exp_se3(velocity * (sweep * sweep_s));
    };
    LocalisationSettings settings;
    settings.T_map_start = at(0);
    settings.sweeps.sampling.max_range_m = 40;
    CloudLocalisation localisation(settings, map, 1);
    LocalisedPath path;
    constexpr int inside = 90, sweeps = 165;
    for (int k = 0; k < sweeps; ++k) {
        if (k > 135) localisation.take_fix(fix_of(at(k), stamp_of(k), 0.3));
        const auto sweep = localisation.add(sweep_at(tunnel, at(k), velocity, stamp_of(k), random));
        path.add(static_cast<std::uint64_t>(k), stamp_of(k), sweep);
        if (k == inside) {
            EXPECT_FALSE(sweep.known);
        }
        if (sweep.known) {
            const Eigen::Vector3d off_m = sweep.T_map_base.translation_m - at(k).translation_m;
            EXPECT_LT(squared_in_sigmas(off_m, sweep.covariance.topLeftCorner<3, 3>()), 30) << k;
        }
    }
    EXPECT_EQ(localisation.counts().lost, 1);
    EXPECT_EQ(localisation.counts().starts, 2) << localisation.latest_look().reason;
    Trajectory trajectory;
    path.lay_out(trajectory);
    ASSERT_EQ(trajectory.size(), static_cast<std::size_t>(sweeps));
    const auto entry = trajectory[inside];
    const Eigen::Vector3d off_m = entry.T_map_base.translation_m - at(inside).translation_m;
    const Eigen::Matrix3d covariance = entry.covariance.matrix().topLeftCorner<3, 3>();
    EXPECT_LT(off_m.norm(), 3);
    EXPECT_LT(squared_in_sigmas(off_m, covariance), 16);
    EXPECT_GT(std::sqrt(covariance(0, 0)), 0.3);
}

TEST(CloudLocalisation, is_moved_by_fixes_only_to_where_sweeps_fit_too) {
    // Two yards alike, 80 m apart.
    const Eigen::Vector3d apart_m = T_map_world().rotation * Eigen::Vector3d(80, 0, 0),
                          astray_m = T_map_world().rotation * Eigen::Vector3d(12, 9, 0);
    std::vector<Rectangle> twins = yard();
    for (Rectangle r : yard()) {
        r.corner_m += apart_m;
        twins.push_back(r);
    }
    const FrozenCloud map = cloud_of(twins);
    const Drive drive;
    LocalisationSettings settings;
    settings.lost_after_s = 0.5;
    for (const bool is_in_the_other : {true, false}) {
        SCOPED_TRACE(is_in_the_other);
        std::mt19937_64 random(8);
        settings.T_map_start = drive.at(0);
        CloudLocalisation localisation(settings, map, 1);
        // Either the vehicle is in the other yard, or the receiver errs by what leads to no yard.
        const Eigen::Vector3d off_m = is_in_the_other ? apart_m : astray_m;
        LocalisedSweep latest;
        for (int k = 0; k < 24; ++k) {
            if (k > 6) localisation.take_fix(fix_of(drive.at(k), stamp_of(k), 0.5, off_m));
            latest = localisation.add(sweep_at(yard(), drive.at(k), drive.velocity, stamp_of(k), random));
        }
        ASSERT_TRUE(latest.known);
        const Eigen::Vector3d expected_m =
            drive.at(23).translation_m + (is_in_the_other ? off_m : Eigen::Vector3d(0, 0, 0));
        EXPECT_LT((latest.T_map_base.translation_m - expected_m).norm(), 0.05);
        EXPECT_EQ(localisation.counts().moved_by_fixes, is_in_the_other ? 1 : 0);
        EXPECT_GT(localisation.counts().fixes_off, 3);
    }
}
