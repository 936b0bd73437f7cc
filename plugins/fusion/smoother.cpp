#include "fusion/smoother.h"

#include <Eigen/Cholesky>

namespace loopline::fusion {
namespace {

EarthState state_of(const Pose3Record& pose, const std::array<double, 3>& fix_error,
                    const std::array<double, 81>& covariance) {
    EarthState state;
    state.T_enu_base = pose.pose();
    state.fix_error_m = Eigen::Map<const Eigen::Vector3d>(fix_error.data());
    state.covariance = Eigen::Map<const Matrix9d>(covariance.data());
    return state;
}

}  // namespace

SmootherStep::SmootherStep(std::size_t pose, const EarthState& before_, const EarthState& after_,
                           const Matrix9d& F_)
    : pose(pose), before(before_.T_enu_base), after(after_.T_enu_base) {
    Eigen::Map<Eigen::Vector3d>(fix_error_before.data()) = before_.fix_error_m;
    Eigen::Map<Eigen::Vector3d>(fix_error_after.data()) = after_.fix_error_m;
    Eigen::Map<Matrix9d>(covariance_before.data()) = before_.covariance;
    Eigen::Map<Matrix9d>(covariance_after.data()) = after_.covariance;
    Eigen::Map<Matrix9d>(F.data()) = F_;
}

EarthState SmootherStep::state_before() const {
    return state_of(before, fix_error_before, covariance_before);
}
EarthState SmootherStep::state_after() const {
    return state_of(after, fix_error_after, covariance_after);
}

EarthState smoothed_before(const SmootherStep& step, const EarthState& smoothed_after) {
    const EarthState before = step.state_before(), after = step.state_after();
    const Matrix9d F = Eigen::Map<const Matrix9d>(step.F.data());
    // C = P F' (P after)^-1
    const Matrix9d C = after.covariance.ldlt().solve(F * before.covariance).transpose();
    EarthState smoothed = moved_by(before, C * difference(smoothed_after, after));
    smoothed.covariance =
        before.covariance + C * (smoothed_after.covariance - after.covariance) * C.transpose();
    smoothed.covariance = (smoothed.covariance + smoothed.covariance.transpose()).eval() / 2;
    return smoothed;
}

}  // namespace loopline::fusion
