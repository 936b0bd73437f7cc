/// Extended Kalman filter on the error of inertial navigation. After each update the estimated error is fed
/// back into the state, so that what the filter carries is always zero and linearisation stays near the
/// truth.
#pragma once

#include <Eigen/Core>

#include "inertial/error_state.h"

namespace loopline::inertial {

/// What became of a measurement.
struct UpdateResult {
    enum class Status {
        accepted,
        gated,     ///< too far from what was expected: nothing changed
        unusable,  ///< innovation covariance not positive, or numbers not finite: nothing changed
        empty,     ///< it says nothing: nothing changed
    };
    Status status = Status::empty;
    double nis =
        0;  ///< innovation' S^-1 innovation: chi-square of `degrees_of_freedom` if all is as modelled
    int degrees_of_freedom = 0;
    bool accepted() const { return status == Status::accepted; }
};

/// A linear measurement of the error: innovation = H error + noise, noise of covariance R.
struct ErrorMeasurement {
    Eigen::Matrix<double, Eigen::Dynamic, error_size> H;
    Eigen::VectorXd innovation;
    Eigen::MatrixXd R;

    explicit ErrorMeasurement(int rows)
        : H(Eigen::Matrix<double, Eigen::Dynamic, error_size>::Zero(rows, error_size)),
          innovation(Eigen::VectorXd::Zero(rows)),
          R(Eigen::MatrixXd::Zero(rows, rows)) {}
};

/// Gate of no limit.
constexpr double no_gate = 1;

class ErrorStateFilter {
 public:
    ErrorStateFilter() = default;
    ErrorStateFilter(const Mechanisation& mechanisation, const ImuNoise& noise)
        : mechanisation_(mechanisation), noise_(noise) {}

    void start(const NavigationState& state, const ErrorMatrix& covariance) {
        state_ = state;
        covariance_ = covariance;
    }

    const NavigationState& state() const { return state_; }
    /// Of error_between(state(), truth).
    const ErrorMatrix& covariance() const { return covariance_; }

    /// From the earlier reading to the later one: P = Phi P Phi' + Q.
    void predict_forward(const ImuSample& from, const ImuSample& to);
    /// From the later reading `to` back to the earlier `from`: P = Phi^-1 (P + Q) Phi^-T, Phi being that of
    /// the forward step. The state must not hold what readings before `to` have told it already, or they
    /// count twice.
    void predict_reverse(const ImuSample& from, const ImuSample& to);

    /// Joseph form, then feedback. `gate_probability` of right measurements pass; no_gate lets all pass.
    UpdateResult update(const ErrorMeasurement& measurement, double gate_probability = no_gate);

 private:
    template <class Archive>
    friend void fields(Archive&, ErrorStateFilter&);

    Mechanisation mechanisation_;
    ImuNoise noise_;
    NavigationState state_;
    ErrorMatrix covariance_ = ErrorMatrix::Zero();
};

/// For checkpoints: api/state_archive.h. What the configuration says is not in it.
template <class Archive>
void fields(Archive& archive, ErrorStateFilter& filter) {
    archive(filter.state_, filter.covariance_);
}

}  // namespace loopline::inertial
