/// The filter of paths on the Earth: Jacobians, and two who tell the same motion.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <functional>

#include "support/fusion_drives.h"

using namespace loopline;
using namespace loopline::fusion;
using namespace loopline::fusion::test;

namespace {

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
    const Matrix6d R = inertial::turned_both(state.T_enu_base.rotation);
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

        const Eigen::Vector3d up_base = drawn(random, 1).normalized();
        const auto upright = [&](const EarthState& s) {
            return innovation_of_upright(s, up_base, Eigen::Matrix2d::Identity());
        };
        EXPECT_LT(largest(upright(state).H + by_differences([&](const StateVector& e) -> Eigen::VectorXd {
                              return upright(moved_by(state, e)).off;
                          })),
                  1e-7);

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

}  // namespace
