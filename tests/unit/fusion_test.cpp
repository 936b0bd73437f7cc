/// Fusion of an odometry with GNSS: Jacobians, heading, consistency, and what becomes of bad fixes.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>
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
    state.wheel_errors << drawn(random, 0.02), drawn(random, 0.02).head<2>();
    state.antenna_off_m = drawn(random, 1);
    const StateMatrix A = StateMatrix::Random();
    state.covariance = 1e-4 * (A * A.transpose());
    return state;
}

/// Columns by central differences over the errors of a state, or others.
template <int errors = state_errors, class Function>
Eigen::MatrixXd by_differences(const Function& f) {
    using Vector = Eigen::Matrix<double, errors, 1>;
    constexpr double h = 1e-6;
    Eigen::MatrixXd J;
    for (int k = 0; k < errors; ++k) {
        const Eigen::VectorXd up = f(h * Vector::Unit(k)), down = f(-h * Vector::Unit(k));
        if (k == 0) J.resize(up.size(), errors);
        J.col(k) = (up - down) / (2 * h);
    }
    return J;
}

double largest(const Eigen::MatrixXd& m) {
    return m.cwiseAbs().maxCoeff();
}

Motion some_motion(std::mt19937_64& random) {
    Motion motion;
    motion.T_from_to = {drawn(random, 1), inertial::exp_so3(drawn(random, 0.3))};
    const Matrix6d A = Matrix6d::Random();
    motion.covariance = 1e-4 * (A * A.transpose());
    return motion;
}

Twist2 some_twist(std::mt19937_64& random) {
    const Eigen::Vector3d d = drawn(random, 1);
    return {2 + d.x(), 0.1 * d.y(), 0.3 * d.z()};
}

const FixErrorProcess some_process{45, {2, 2, 4}};

/// The covariances of carry() are those of its mean, of which the derivative is F.
void expect_carried(const EarthState& state, const StateAndMotion& both,
                    const std::function<Pose3(const EarthState&)>& motion_from, const Matrix6d& added) {
    WheelNoise noise;
    const Carried carried = carry(both, 0.1, some_process, noise);
    const auto after = [&](const EarthState& from) {
        EarthState next = from;
        next.T_enu_base = from.T_enu_base * motion_from(from);
        next.fix_error_m *= std::exp(-0.1 / some_process.correlation_s);
        return next;
    };
    EXPECT_LT(largest(difference(carried.after, after(state))), 1e-12);
    const StateMatrix F = by_differences([&](const StateVector& e) -> Eigen::VectorXd {
        return difference(after(moved_by(state, e)), after(state));
    });
    EXPECT_LT(largest(carried.before_and_after - state.covariance * F.transpose()), 1e-9);
    StateMatrix P = F * state.covariance * F.transpose();
    const Matrix6d R = turned_both(state.T_enu_base.rotation);
    P.topLeftCorner<6, 6>() += R * added * R.transpose();
    P.diagonal().segment<3>(fix_errors_at) +=
        (1 - std::exp(-0.2 / some_process.correlation_s)) * some_process.sigma_m.cwiseAbs2();
    P.diagonal().segment<wheel_error_count>(wheel_errors_at) +=
        both.T_from_to.translation_m.norm() / 1000 * noise.drift_km.cwiseAbs2();
    EXPECT_LT(largest(carried.after.covariance - P), 1e-8);
}

TEST(EarthFilter, jacobians_are_central_differences) {
    std::mt19937_64 random(3);
    for (int run = 0; run < 20; ++run) {
        const EarthState state = some_state(random);
        const Motion motion = some_motion(random);
        expect_carried(
            state, with_odometry(state, motion), [&](const EarthState&) { return motion.T_from_to; },
            motion.covariance);
        Twist2 told = some_twist(random);
        if (run % 4 == 0) told.turn_rad = 1e-6;
        if (run % 4 == 1) told = {};
        expect_carried(
            state, with_wheels(state, told, {}),
            [&](const EarthState& s) { return in_space(corrected(told, s.wheel_errors)); },
            noise_of(told, {}));

        const Pose3 T_base_then{drawn(random, 0.3), inertial::exp_so3(drawn(random, 0.1))};
        const Eigen::Vector3d p_enu_m = drawn(random, 20), v_base_mps = drawn(random, 5);
        const auto place = [&](const EarthState& s) {
            return innovation_of_place(s, T_base_then, p_base_antenna_m, p_enu_m, {1, 1, 1});
        };
        EXPECT_LT(largest(place(state).H + by_differences([&](const StateVector& e) -> Eigen::VectorXd {
                              return place(moved_by(state, e)).off;
                          })),
                  1e-7);
        for (const bool by_wheels : {false, true}) {
            const auto velocity = [&](const EarthState& s) {
                const double longer = (1 + s.wheel_errors[way_scale]) / (1 + state.wheel_errors[way_scale]);
                return innovation_of_velocity(s, T_base_then, by_wheels ? longer * v_base_mps : v_base_mps,
                                              by_wheels, {3, 4}, 0.1);
            };
            EXPECT_LT(
                largest(velocity(state).H + by_differences([&](const StateVector& e) -> Eigen::VectorXd {
                            return velocity(moved_by(state, e)).off;
                        })),
                1e-7);
        }

        // The errors of wheels grow with the odometry's turn: but for the product of these errors with its
        // own.
        EarthState without_wheel_errors = state;
        without_wheel_errors.wheel_errors.setZero();
        const StateAndMotion both = with_odometry(without_wheel_errors, motion);
        const auto beside = [&](const Eigen::Matrix<double, StateAndMotion::errors, 1>& e) {
            StateAndMotion other = both;
            other.state = moved_by(both.state, e.head<state_errors>());
            other.T_from_to.translation_m += e.segment<3>(state_errors);
            other.T_from_to.rotation =
                inertial::exp_so3(e.tail<3>()) * inertial::exp_so3({0, 0, told.turn_rad});
            return other;
        };
        const auto zero = beside(Eigen::Matrix<double, StateAndMotion::errors, 1>::Zero());
        EXPECT_LT(
            largest(innovation_of_wheels(zero, told, {}).H +
                    by_differences<StateAndMotion::errors>(
                        [&](const Eigen::Matrix<double, StateAndMotion::errors, 1>& e) -> Eigen::VectorXd {
                            return innovation_of_wheels(beside(e), told, {}).off;
                        })),
            0.02 * std::abs(told.turn_rad) + 1e-6)
            << "but for the product of two turns";
    }
}

// An odometry and wheels tell the same motion: what is then known is what least squares over all of it at
// once say, of the motion as of the wheels' errors.
TEST(EarthFilter, wheels_beside_an_odometry_are_least_squares_over_both) {
    std::mt19937_64 random(8);
    for (int run = 0; run < 20; ++run) {
        const EarthState state = some_state(random);
        const Twist2 told = some_twist(random);
        Motion motion = some_motion(random);
        motion.T_from_to = in_space(corrected(told, state.wheel_errors)) *
                           Pose3{drawn(random, 1e-4), inertial::exp_so3(drawn(random, 1e-5))};
        const StateAndMotion both = with_odometry(state, motion);
        const WheelInnovation wheels = innovation_of_wheels(both, told, {});
        const StateAndMotion after = updated(both, wheels);
        const StateAndMotion::Matrix information =
            both.covariance.inverse() + wheels.H.transpose() * wheels.noise.inverse() * wheels.H;
        const Eigen::Matrix<double, StateAndMotion::errors, 1> error =
            information.inverse() * wheels.H.transpose() * wheels.noise.inverse() * wheels.off;
        EXPECT_LT(largest(after.covariance - information.inverse()), 1e-8);
        EXPECT_LT(largest(difference(after.state, state) - error.head<state_errors>()), 1e-8);
        EXPECT_LT(largest(after.T_from_to.translation_m - both.T_from_to.translation_m -
                          error.segment<3>(state_errors)),
                  1e-8);
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

/// Wheels beside the odometry, or alone.
struct Wheels {
    bool alone = false;
    WheelErrors errors{0.02, -0.05, 0.15 * rad, 0, 0};  ///< by which the truth is larger
    double along_m = 0.01, turn_rad = 0.05 * rad;       ///< noise after 1 m
    double slip_from_s = 1e9, slip_to_s = 1e9;          ///< they tell half as much again
    bool odometry_is_blind = false;  ///< within the receiver's outage it stands still forward, and says so
};

/// What wheels would have to tell for `twist` to be the truth.
Twist2 told_of(const Twist2& twist, const WheelErrors& errors) {
    const double forward_m = twist.forward_m / (1 + errors[way_scale]);
    return {forward_m, twist.left_m / (1 + errors[way_scale]),
            (twist.turn_rad - errors[bend] * forward_m) / (1 + errors[turn_scale])};
}

constexpr double odometry_sigma_m = 0.003, odometry_sigma_rad = 0.004 * rad;

EarthPath followed(const Drive& drive, const Receiver& receiver, std::uint64_t seed,
                   EarthPathSettings settings = {}, std::vector<std::optional<EarthState>>* online = nullptr,
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
            if (T.translation_m.norm() > 0) {
                T.translation_m += drawn(random, odometry_sigma_m);
                T.rotation = inertial::exp_so3(drawn(random, odometry_sigma_rad)) * T.rotation;
                covariance.diagonal() << Eigen::Vector3d::Constant(odometry_sigma_m * odometry_sigma_m),
                    Eigen::Vector3d::Constant(odometry_sigma_rad * odometry_sigma_rad);
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
            Eigen::Vector3d p_enu_m = drive.at(fix_ns) * (p_base_antenna_m + antenna_off_m) + error_m;
            if (t > receiver.jump_from_s && t < receiver.jump_to_s) p_enu_m += receiver.jump_m;
            fix.antenna = frame.geodetic(p_enu_m);
            fix.p_base_antenna_m = p_base_antenna_m;
            path.take_fix(fix, t > withhold_from_s && t < withhold_to_s);
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
        horizontal += off_m.dot(end.covariance.topLeftCorner<2, 2>().ldlt().solve(off_m)) / runs;
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

// The antenna is not where the log says: turning tells.
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
