#include "inertial/error_state_filter.h"

#include <Eigen/Cholesky>

#include "api/dense_algebra.h"
#include "least_squares/chi_square.h"

namespace loopline::inertial {
namespace {

void make_symmetric(ErrorMatrix& P) {
    P = (0.5 * (P + P.transpose())).eval();
}

}  // namespace

void ErrorStateFilter::predict_forward(const ImuSample& from, const ImuSample& to) {
    const ErrorMatrix Phi = transition(state_, from, to);
    const double dt = seconds_between(from.stamp_ns, to.stamp_ns);
    covariance_ = propagated(Phi, covariance_) + process_noise(noise_, Phi, dt);
    make_symmetric(covariance_);
    state_ = mechanisation_.forward(state_, from, to);
}

void ErrorStateFilter::predict_reverse(const ImuSample& from, const ImuSample& to) {
    state_ = mechanisation_.reverse(state_, from, to);
    const ErrorMatrix Phi = transition(state_, from, to), inverse = inverse_transition(state_, from, to);
    const double dt = seconds_between(from.stamp_ns, to.stamp_ns);
    covariance_ = propagated(inverse, covariance_ + process_noise(noise_, Phi, dt));
    make_symmetric(covariance_);
}

UpdateResult ErrorStateFilter::update(const ErrorMeasurement& measurement, double gate_probability) {
    const auto& [H, innovation, R] = measurement;
    UpdateResult result;
    result.degrees_of_freedom = static_cast<int>(innovation.size());
    if (result.degrees_of_freedom == 0) return result;

    const Eigen::MatrixXd S = propagated(H, covariance_) + R;
    const Eigen::LLT<Eigen::MatrixXd> S_factor(S);
    result.status = UpdateResult::Status::unusable;
    if (!S.allFinite() || !innovation.allFinite() || S_factor.info() != Eigen::Success) return result;
    result.nis = innovation.dot(S_factor.solve(innovation));
    if (!std::isfinite(result.nis)) return result;

    result.status = UpdateResult::Status::gated;
    if (gate_probability < no_gate &&
        result.nis > least_squares::chi_square_quantile(result.degrees_of_freedom, gate_probability))
        return result;

    result.status = UpdateResult::Status::accepted;
    const Eigen::MatrixXd gain = S_factor.solve(product(H, covariance_)).transpose();
    const ErrorVector error = product(gain, innovation);
    covariance_ = updated_covariance(covariance_, gain, H, R);
    covariance_ = covariance_after_injection(covariance_, error);
    make_symmetric(covariance_);
    state_ = inject(state_, error);
    return result;
}

}  // namespace loopline::inertial
