/// Drives of which everything is known, and what an odometry, wheels and a receiver make of them.
#pragma once

#include <cmath>
#include <random>

#include "api/dense_algebra.h"
#include "fusion/earth_path.h"

namespace loopline::fusion::test {

inline constexpr StampNs second = 1'000'000'000;
inline constexpr double rad = M_PI / 180;
inline const gnss::Geodetic origin{49, 8.4, 200};
inline const Eigen::Vector3d p_base_antenna_m(-0.6, 0.25, 1.6);

inline Eigen::Vector3d drawn(std::mt19937_64& random, double sigma) {
    std::normal_distribution<double> normal(0, sigma);
    const double x = normal(random), y = normal(random), z = normal(random);
    return {x, y, z};
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
    double latency_s = 0.15, sigma_latency_s = 0;  ///< that stamps do not tell
    double scale_in_outage = 1;                    ///< of the odometry
    double first_away_m = 0;                       ///< of the first two fixes from where they should be
    double first_ahead_s = 0;                      ///< by which the stamps of the first two fixes are off
    /// Standard deviation of each of the odometry's motions in the outage, forward: as along a tunnel, and by
    /// a direction that each sweep tells anew, and not quite.
    double free_in_outage_m = 0;
    double leans_at_s = 1e9, lean_rad = 0;  ///< the odometry tells a pitch that there was none of
};

/// Wheels beside the odometry, or alone.
struct Wheels {
    bool alone = false;
    WheelErrors errors{0.02, -0.05, 0.15 * rad, 0, 0};  ///< by which the truth is larger
    double along_m = 0.01, turn_rad = 0.05 * rad;       ///< noise after 1 m
    double slip_from_s = 1e9, slip_to_s = 1e9;          ///< they tell half as much again
    bool odometry_is_blind = false;  ///< within the receiver's outage it stands still forward, and says so
};

/// What wheels would have to tell for `twist` to be the truth.
inline Twist2 told_of(const Twist2& twist, const WheelErrors& errors) {
    const double forward_m = twist.forward_m / (1 + errors[way_scale]);
    return {forward_m, twist.left_m / (1 + errors[way_scale]),
            (twist.turn_rad - errors[bend] * forward_m) / (1 + errors[turn_scale])};
}

inline constexpr double odometry_sigma_m = 0.003, odometry_sigma_rad = 0.004 * rad;

inline EarthPath followed(const Drive& drive, const Receiver& receiver, std::uint64_t seed,
                          EarthPathSettings settings = {},
                          std::vector<std::optional<EarthState>>* online = nullptr,
                          const std::optional<Wheels>& wheels = std::nullopt, double withhold_from_s = 1e9,
                          double withhold_to_s = 1e9, const Eigen::Vector3d& antenna_off_m = {0, 0, 0}) {
    std::mt19937_64 random(seed);
    const gnss::LocalFrame frame(origin);
    EarthPath path(settings);
    Eigen::Vector3d slow_m = drawn(random, receiver.correlated_m);
    const double keeps = std::exp(-0.2 / receiver.correlation_s);
    Pose3 T_odom_base;
    StampNs fix_ns = drive.stamps_ns.front() + second / 17;
    for (std::size_t k = 0; k < drive.stamps_ns.size(); ++k) {
        Matrix6d covariance = Matrix6d::Zero();
        std::optional<Twist2> told;
        if (k > 0) {
            Pose3 T = drive.T_enu_base[k - 1].inverse() * drive.T_enu_base[k];
            const double t = seconds_between(drive.stamps_ns.front(), drive.stamps_ns[k]);
            if (t > receiver.outage_from_s && t < receiver.outage_to_s)
                T.translation_m *= receiver.scale_in_outage;
            if (t > receiver.leans_at_s && t < receiver.leans_at_s + 0.101)
                T.rotation = T.rotation * inertial::exp_so3({0, receiver.lean_rad, 0});
            if (T.translation_m.norm() > 0) {
                T.translation_m += drawn(random, odometry_sigma_m);
                T.rotation = inertial::exp_so3(drawn(random, odometry_sigma_rad)) * T.rotation;
                covariance.diagonal() << Eigen::Vector3d::Constant(odometry_sigma_m * odometry_sigma_m),
                    Eigen::Vector3d::Constant(odometry_sigma_rad * odometry_sigma_rad);
            }
            if (receiver.free_in_outage_m > 0 && t > receiver.outage_from_s && t < receiver.outage_to_s) {
                const Eigen::Vector3d across = drawn(random, 2e-3), turn = drawn(random, 1e-4);
                Eigen::Matrix<double, 6, 1> free;
                free << 1, across.y(), across.z(), turn;
                free *= receiver.free_in_outage_m;
                covariance += free * free.transpose();
            }
            if (wheels) {
                const Twist3 twist = log_se3(drive.T_enu_base[k - 1].inverse() * drive.T_enu_base[k]);
                told = told_of({twist.shift_m.x(), twist.shift_m.y(), twist.turn_rad.z()}, wheels->errors);
                const double root = std::sqrt(std::abs(told->forward_m));
                const Eigen::Vector3d noise = root * drawn(random, 1);
                told->forward_m += wheels->along_m * noise.x();
                told->turn_rad += wheels->turn_rad * noise.z();
                if (t > wheels->slip_from_s && t < wheels->slip_to_s) told->forward_m *= 1.5;
                if (wheels->odometry_is_blind && t > receiver.outage_from_s && t < receiver.outage_to_s) {
                    T.translation_m.x() = 0;
                    covariance(0, 0) = 1e4;
                }
            }
            T_odom_base = T_odom_base * T;
        }
        if (wheels && wheels->alone)
            path.take_wheels(drive.stamps_ns[k], told.value_or(Twist2{}));
        else
            path.take_pose(drive.stamps_ns[k], T_odom_base, covariance, told);
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
            const double late_s =
                receiver.sigma_latency_s > 0 ? drawn(random, receiver.sigma_latency_s).x() : 0;
            const StampNs seen_ns =
                std::max<StampNs>(drive.stamps_ns.front(), fix_ns - std::llround(1e9 * late_s));
            Eigen::Vector3d p_enu_m = drive.at(seen_ns) * (p_base_antenna_m + antenna_off_m) + error_m;
            if (t > receiver.jump_from_s && t < receiver.jump_to_s) p_enu_m += receiver.jump_m;
            if (t < 0.4) p_enu_m.x() += receiver.first_away_m;
            fix.antenna = frame.geodetic(p_enu_m);
            fix.p_base_antenna_m = p_base_antenna_m;
            if (t < 0.4) fix.stamp_ns += std::llround(1e9 * receiver.first_ahead_s);
            path.take_fix(fix, t > withhold_from_s && t < withhold_to_s);
        }
    }
    return path;
}

inline EarthPathSettings as_simulated(const Receiver& receiver) {
    EarthPathSettings settings;
    settings.drift_m = settings.drift_rad = 0;
    settings.sigma_latency_s = receiver.sigma_latency_s;
    for (gnss::FixNoise* noise : {&settings.noise.fixed, &settings.noise.single})
        *noise = {receiver.white_m, receiver.correlated_m, receiver.correlation_s};
    return settings;
}

/// From the truth's frame, about `origin`, to that of the first fix.
inline Pose3 T_path_truth(const EarthPath& path) {
    const gnss::LocalFrame frame(origin);
    return {path.earth()->p_enu_m(origin), Eigen::Quaterniond::Identity()};
}

inline double nees(const Pose3& estimate, const Pose3& truth, const Matrix6d& covariance) {
    Eigen::Matrix<double, 6, 1> e;
    e << estimate.translation_m - truth.translation_m,
        inertial::log_so3(estimate.rotation * truth.rotation.conjugate());
    return squared_in_sigmas(e, covariance);
}

}  // namespace loopline::fusion::test
