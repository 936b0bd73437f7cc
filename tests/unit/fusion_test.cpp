/// Fusion of an odometry with GNSS: Jacobians, heading, consistency, and what becomes of bad fixes.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "fusion/earth_path.h"

using namespace loopline;
using namespace loopline::fusion;

namespace {

constexpr StampNs second = 1'000'000'000;
constexpr double rad = M_PI / 180;
const gnss::Geodetic origin{49, 8.4, 200};
const Eigen::Vector3d p_base_antenna_m(-0.6, 0.25, 1.6);

Eigen::Vector3d drawn(std::mt19937_64& random, double sigma) {
    std::normal_distribution<double> normal(0, sigma);
    const double x = normal(random), y = normal(random), z = normal(random);
    return {x, y, z};
}

EarthState some_state(std::mt19937_64& random) {
    EarthState state;
    state.T_enu_base = {drawn(random, 20), inertial::exp_so3(drawn(random, 1))};
    state.fix_error_m = drawn(random, 1);
    const Matrix9d A = Matrix9d::Random();
    state.covariance = 1e-2 * (A * A.transpose());
    return state;
}

/// Columns by central differences over the nine errors of a state.
template <class Function>
Eigen::MatrixXd by_differences(const Function& f) {
    constexpr double h = 1e-6;
    Eigen::MatrixXd J;
    for (int k = 0; k < 9; ++k) {
        const Eigen::VectorXd up = f(h * Vector9d::Unit(k)), down = f(-h * Vector9d::Unit(k));
        if (k == 0) J.resize(up.size(), 9);
        J.col(k) = (up - down) / (2 * h);
    }
    return J;
}

TEST(EarthFilter, jacobians_are_central_differences) {
    std::mt19937_64 random(3);
    for (int run = 0; run < 20; ++run) {
        const EarthState state = some_state(random);
        const Motion motion{0, second / 10, {drawn(random, 1), inertial::exp_so3(drawn(random, 0.3))}, {}};
        Matrix9d F;
        const EarthState next = predict(state, motion, 45, {2, 2, 4}, &F);
        EXPECT_LT((F - by_differences([&](const Vector9d& e) -> Eigen::VectorXd {
                       return difference(predict(moved_by(state, e), motion, 45, {2, 2, 4}), next);
                   }))
                      .cwiseAbs()
                      .maxCoeff(),
                  1e-7);
        const Pose3 T_base_then{drawn(random, 0.3), inertial::exp_so3(drawn(random, 0.1))};
        const Eigen::Vector3d p_enu_m = drawn(random, 20), v_base_mps = drawn(random, 5);
        const auto place = [&](const EarthState& s) {
            return innovation_of_place(s, T_base_then, p_base_antenna_m, p_enu_m, {1, 1, 1});
        };
        const auto velocity = [&](const EarthState& s) {
            return innovation_of_velocity(s, T_base_then, v_base_mps, {3, 4}, 0.1);
        };
        EXPECT_LT((place(state).H + by_differences([&](const Vector9d& e) -> Eigen::VectorXd {
                       return place(moved_by(state, e)).off;
                   }))
                      .cwiseAbs()
                      .maxCoeff(),
                  1e-7);
        EXPECT_LT((velocity(state).H + by_differences([&](const Vector9d& e) -> Eigen::VectorXd {
                       return velocity(moved_by(state, e)).off;
                   }))
                      .cwiseAbs()
                      .maxCoeff(),
                  1e-7);
    }
}

/// A drive along a street with bends and a slope: what an odometry and a receiver make of it.
struct Drive {
    std::vector<StampNs> stamps_ns;
    std::vector<Pose3> T_enu_base;  ///< truth
    double heading_rad = 0;

    /// Standing for 2 s, then at 8 m/s; poses at 10 Hz.
    Drive(double seconds, double heading) : heading_rad(heading) {
        Pose3 T{{0, 0, 0}, inertial::exp_so3({0, 0, heading})};
        for (int k = 0; k <= 10 * seconds; ++k) {
            stamps_ns.push_back(100 * second + k * second / 10);
            T_enu_base.push_back(T);
            const double t = k / 10.0, speed = t < 2 ? 0 : std::min(8.0, 2 * (t - 2));
            T = T * exp_se3({{0.1 * speed, 0, 0},
                             {0, 0.1 * 0.01 * std::cos(t / 5), 0.1 * 0.15 * std::sin(t / 7) * (t > 8)}});
        }
    }
    Pose3 at(StampNs stamp_ns) const {
        const auto k = static_cast<std::size_t>((stamp_ns - stamps_ns.front()) / (second / 10));
        if (k + 1 >= stamps_ns.size()) return T_enu_base.back();
        return interpolate_se3(T_enu_base[k], T_enu_base[k + 1],
                               seconds_between(stamps_ns[k], stamp_ns) / 0.1);
    }
};

struct Receiver {
    gnss::FixQuality quality = gnss::FixQuality::rtk_fixed;
    double white_m = 0.01, correlated_m = 0.005, correlation_s = 60;
    double outage_from_s = 1e9, outage_to_s = 1e9;  ///< since the start
    double jump_from_s = 1e9, jump_to_s = 1e9;
    Eigen::Vector3d jump_m = Eigen::Vector3d::Zero();
    double latency_s = 0.15;
    double scale_in_outage = 1;  ///< of the odometry
};

constexpr double odometry_sigma_m = 0.003, odometry_sigma_rad = 0.004 * rad;

EarthPath followed(const Drive& drive, const Receiver& receiver, std::uint64_t seed,
                   EarthPathSettings settings = {},
                   std::vector<std::optional<EarthState>>* online = nullptr) {
    std::mt19937_64 random(seed);
    const gnss::LocalFrame frame(origin);
    EarthPath path(settings);
    Eigen::Vector3d slow_m = drawn(random, receiver.correlated_m);
    const double keeps = std::exp(-0.2 / receiver.correlation_s);
    Pose3 T_odom_base;
    StampNs fix_ns = drive.stamps_ns.front() + second / 17;
    for (std::size_t k = 0; k < drive.stamps_ns.size(); ++k) {
        Matrix6d covariance = Matrix6d::Zero();
        if (k > 0) {
            Pose3 T = drive.T_enu_base[k - 1].inverse() * drive.T_enu_base[k];
            const double t = seconds_between(drive.stamps_ns.front(), drive.stamps_ns[k]);
            if (t > receiver.outage_from_s && t < receiver.outage_to_s)
                T.translation_m *= receiver.scale_in_outage;
            if (T.translation_m.norm() > 0) {
                T.translation_m += drawn(random, odometry_sigma_m);
                T.rotation = inertial::exp_so3(drawn(random, odometry_sigma_rad)) * T.rotation;
                covariance.diagonal() << Eigen::Vector3d::Constant(odometry_sigma_m * odometry_sigma_m),
                    Eigen::Vector3d::Constant(odometry_sigma_rad * odometry_sigma_rad);
            }
            T_odom_base = T_odom_base * T;
        }
        path.take_pose(drive.stamps_ns[k], T_odom_base, covariance);
        if (online != nullptr) online->push_back(path.latest());
        for (; fix_ns + std::llround(1e9 * receiver.latency_s) <= drive.stamps_ns[k]; fix_ns += second / 5) {
            const double t = seconds_between(drive.stamps_ns.front(), fix_ns);
            const Eigen::Vector3d kind(1, 1, 2);
            slow_m = keeps * slow_m + std::sqrt(1 - keeps * keeps) * drawn(random, receiver.correlated_m);
            const Eigen::Vector3d error_m = (slow_m + drawn(random, receiver.white_m)).cwiseProduct(kind);
            gnss::GnssFix fix;
            fix.stamp_ns = fix_ns;
            fix.quality = receiver.quality;
            fix.has_position = fix.has_height = t < receiver.outage_from_s || t > receiver.outage_to_s;
            Eigen::Vector3d p_enu_m = drive.at(fix_ns) * p_base_antenna_m + error_m;
            if (t > receiver.jump_from_s && t < receiver.jump_to_s) p_enu_m += receiver.jump_m;
            fix.antenna = frame.geodetic(p_enu_m);
            fix.p_base_antenna_m = p_base_antenna_m;
            path.take_fix(fix);
        }
    }
    return path;
}

EarthPathSettings as_simulated(const Receiver& receiver) {
    EarthPathSettings settings;
    settings.drift_m = settings.drift_rad = 0;
    for (FixNoise* noise : {&settings.noise.fixed, &settings.noise.single})
        *noise = {receiver.white_m, receiver.correlated_m, receiver.correlation_s};
    return settings;
}

/// From the truth's frame, about `origin`, to that of the first fix.
Pose3 T_path_truth(const EarthPath& path) {
    const gnss::LocalFrame frame(origin);
    return {path.earth()->p_enu_m(origin), Eigen::Quaterniond::Identity()};
}

double nees(const Pose3& estimate, const Pose3& truth, const Matrix6d& covariance) {
    Eigen::Matrix<double, 6, 1> e;
    e << estimate.translation_m - truth.translation_m,
        inertial::log_so3(estimate.rotation * truth.rotation.conjugate());
    return e.dot(covariance.ldlt().solve(e));
}

TEST(EarthPath, heading_is_known_within_a_degree_after_20_m_wherever_the_vehicle_looks) {
    for (int k = 0; k < 12; ++k) {
        const Drive drive(8, (30 * k - 170) * rad);
        std::vector<std::optional<EarthState>> online;
        const EarthPath path = followed(drive, {}, static_cast<std::uint64_t>(k), {}, &online);
        ASSERT_TRUE(path.heading_known());
        EXPECT_LT(path.heading_way_m(), 5);
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
TEST(EarthPath, covariances_are_right_over_50_drives) {
    const Receiver receiver;
    const EarthPathSettings settings = as_simulated(receiver);
    const Drive drive(60, 0.7);
    const std::size_t looks[] = {200, 350, 500, 590};
    double online_sum[4] = {}, smoothed_sum[4] = {};
    constexpr int runs = 50;
    for (std::uint64_t seed = 0; seed < runs; ++seed) {
        std::vector<std::optional<EarthState>> online;
        EarthPath path = followed(drive, receiver, seed, settings, &online);
        const Pose3 T = T_path_truth(path);
        const auto smoothed = path.smoothed();
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
    const auto smoothed = path.smoothed();
    double online_worst_m = 0, smoothed_worst_m = 0;
    for (std::size_t i = 200; i < 800; ++i) {
        online_worst_m = std::max(online_worst_m, off_m(online[i]->T_enu_base, i));
        smoothed_worst_m = std::max(smoothed_worst_m, off_m(smoothed[i].T_enu_base, i));
    }
    EXPECT_LT(smoothed_worst_m, 0.7 * online_worst_m);
    EXPECT_EQ(path.re_entries(), 0U);
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
        const auto smoothed = path.smoothed();
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
    const auto smoothed = path.smoothed();
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

TEST(FixNoise, reported_deviations_count_only_if_they_are_worse_than_the_kind_of_fix) {
    const FixNoiseSettings settings;
    gnss::GnssFix fix;
    fix.quality = gnss::FixQuality::single;
    const SigmaOfFix plain = sigma_of(fix, settings);
    EXPECT_EQ(plain.white_m.x(), settings.single.white_m);
    EXPECT_EQ(plain.correlated_m.z(), 2 * settings.single.correlated_m);
    fix.sigma_enu_m = Eigen::Vector3d(0.1, 0.1, 0.1);
    EXPECT_EQ(sigma_of(fix, settings).correlated_m, plain.correlated_m) << "too good to be true";
    fix.sigma_enu_m = Eigen::Vector3d(20, 20, 40);
    const SigmaOfFix poor = sigma_of(fix, settings);
    EXPECT_NEAR(std::hypot(poor.white_m.x(), poor.correlated_m.x()), 20, 1e-9);
}

}  // namespace
