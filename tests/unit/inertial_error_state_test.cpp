/// Error state: transition against central differences of the mechanisation, process noise against sampled
/// errors, feedback.
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/inertial_drive.h"

using namespace loopline;
using namespace loopline::inertial;

namespace {

/// A state and a step with nothing small in it: a tenth of a second at 2 rad/s, tilted, biased.
struct Step {
    NavigationState state;
    ImuSample from, to;
    Step() {
        state.q_map_base = exp_so3({0.3, -0.5, 2});
        state.v_map_mps = {1, -2, 0.5};
        state.p_map_m = {10, 20, -5};
        state.gyro_bias_radps = {0.02, -0.01, 0.03};
        state.accelerometer_bias_mps2 = {0.2, 0.1, -0.3};
        from.omega_base_radps = {1, -0.5, 2};
        from.specific_force_base_mps2 = {1, -3, 9};
        to.stamp_ns = 100'000'000;
        to.omega_base_radps = {0.8, 0.4, 1.5};
        to.specific_force_base_mps2 = {2, 1, 11};
    }
};

/// Derivative of the error at the end of `step` by that at its start.
template <class StepFunction>
ErrorMatrix central_differences(const NavigationState& state, const StepFunction& step) {
    constexpr double h = 1e-6;
    const NavigationState end = step(state);
    ErrorMatrix J;
    for (int i = 0; i < error_size; ++i) {
        const ErrorVector e = h * ErrorVector::Unit(i);
        J.col(i) =
            (error_between(end, step(inject(state, e))) - error_between(end, step(inject(state, -e)))) /
            (2 * h);
    }
    return J;
}

/// Largest deviation of sampled variances, and of correlations, from those of P.
void expect_like_samples(const ErrorMatrix& P, const ErrorMatrix& sampled, double tolerance) {
    for (int i = 0; i < error_size; ++i) {
        EXPECT_NEAR(sampled(i, i) / P(i, i), 1, tolerance) << i;
        for (int j = 0; j < i; ++j) {
            const double scale = std::sqrt(P(i, i) * P(j, j));
            EXPECT_NEAR(sampled(i, j) / scale, P(i, j) / scale, tolerance) << i << ", " << j;
        }
    }
}

}  // namespace

TEST(InertialErrorState, transition_is_the_derivative_of_the_mechanisation) {
    const Step s;
    const Mechanisation mechanisation;
    const auto expected = central_differences(
        s.state, [&](const NavigationState& x) { return mechanisation.forward(x, s.from, s.to); });
    EXPECT_LT((transition(s.state, s.from, s.to) - expected).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(InertialErrorState, inverse_transition_is_the_derivative_of_the_reverse_mechanisation) {
    const Step s;
    const Mechanisation mechanisation;
    const NavigationState end = mechanisation.forward(s.state, s.from, s.to);
    const auto expected = central_differences(
        end, [&](const NavigationState& x) { return mechanisation.reverse(x, s.from, s.to); });
    const ErrorMatrix inverse = inverse_transition(s.state, s.from, s.to);
    EXPECT_LT((inverse - expected).cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_LT((inverse * transition(s.state, s.from, s.to) - ErrorMatrix::Identity()).cwiseAbs().maxCoeff(),
              1e-14);
}

TEST(InertialErrorState, transition_holds_for_tiny_and_no_rotation) {
    Step s;
    for (const double rate : {0.0, 1e-7, 1e-3, 0.05}) {
        s.state.gyro_bias_radps.setZero();
        s.from.omega_base_radps = s.to.omega_base_radps = {rate, -rate, 2 * rate};
        const Mechanisation mechanisation;
        const auto expected = central_differences(
            s.state, [&](const NavigationState& x) { return mechanisation.forward(x, s.from, s.to); });
        EXPECT_LT((transition(s.state, s.from, s.to) - expected).cwiseAbs().maxCoeff(), 1e-8) << rate;
    }
}

TEST(InertialErrorState, process_noise_is_the_spread_of_sampled_drives) {
    // Walks of biases that matter within the three seconds.
    const ImuNoise noise{{1e-3, 1e-3}, {1e-2, 1e-2}};
    constexpr int drives = 3000;
    constexpr double duration_s = 3, rate_hz = 50;
    const Mechanisation mechanisation;
    std::mt19937_64 random(5);
    ErrorMatrix sampled = ErrorMatrix::Zero(), P = ErrorMatrix::Zero();
    for (int drive = 0; drive < drives; ++drive) {
        const auto run = test::simulate_imu({}, duration_s, rate_hz, noise, {}, random);
        NavigationState state = run.truth.front();
        for (std::size_t i = 1; i < run.samples.size(); ++i) {
            const auto &from = run.samples[i - 1], &to = run.samples[i];
            if (drive == 0) {
                const ErrorMatrix Phi = transition(state, from, to);
                P = (Phi * P * Phi.transpose() + process_noise(noise, Phi, 1 / rate_hz)).eval();
            }
            state = mechanisation.forward(state, from, to);
        }
        const ErrorVector e = error_between(state, run.truth.back());
        sampled += e * e.transpose() / drives;
    }
    // One sigma of a sampled variance is sqrt(2 / drives) = 2.6 %.
    expect_like_samples(P, sampled, 0.08);
}

TEST(InertialErrorState, process_noise_does_not_depend_on_the_number_of_steps) {
    const ImuNoise noise{{1e-3, 1e-3}, {1e-2, 1e-2}};
    const test::SmoothDrive drive;
    const auto grown = [&](int steps) {
        NavigationState state;
        ErrorMatrix P = ErrorMatrix::Zero();
        for (int i = 0; i < steps; ++i) {
            const auto from = drive.reading(2.0 * i / steps), to = drive.reading(2.0 * (i + 1) / steps);
            const ErrorMatrix Phi = transition(state, from, to);
            P = (Phi * P * Phi.transpose() + process_noise(noise, Phi, 2.0 / steps)).eval();
            state = Mechanisation().forward(state, from, to);
        }
        return P;
    };
    const ErrorMatrix coarse = grown(100), fine = grown(1000);
    for (int i = 0; i < error_size; ++i) EXPECT_NEAR(coarse(i, i) / fine(i, i), 1, 1e-3) << i;
}

TEST(InertialErrorState, inject_and_error_between_are_inverse) {
    const Step s;
    ErrorVector error;
    error << 1, 2, 3, 0.1, 0.2, 0.3, 0.5, -0.7, 1.2, 0.01, 0.02, 0.03, 0.1, 0.2, 0.3;
    const NavigationState corrected = inject(s.state, error);
    EXPECT_LT((error_between(s.state, corrected) - error).norm(), 1e-12);
    EXPECT_NEAR(corrected.q_map_base.norm(), 1, 1e-15);
}

TEST(InertialErrorState, covariance_after_injection_is_that_of_what_is_left) {
    const Step s;
    ErrorVector fed_back = ErrorVector::Zero();
    fed_back.segment<3>(attitude_error) << 0.4, -0.3, 0.5;
    const NavigationState corrected = inject(s.state, fed_back);
    // Truths around the fed back error, as errors of the corrected state: by central differences.
    constexpr double h = 1e-6;
    ErrorMatrix G;
    for (int i = 0; i < error_size; ++i) {
        const ErrorVector e = h * ErrorVector::Unit(i);
        G.col(i) = (error_between(corrected, inject(s.state, fed_back + e)) -
                    error_between(corrected, inject(s.state, fed_back - e))) /
                   (2 * h);
    }
    std::srand(1);  // the same matrix, whatever tests came before
    ErrorMatrix P = ErrorMatrix::Random();
    P = (P * P.transpose()).eval();
    EXPECT_LT((covariance_after_injection(P, fed_back) - G * P * G.transpose()).cwiseAbs().maxCoeff(), 1e-8);
}
