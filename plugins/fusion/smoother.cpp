#include "fusion/smoother.h"

#include <Eigen/Cholesky>

namespace loopline::fusion {

EarthStateRecord::EarthStateRecord(const EarthState& state) : T_enu_base(state.T_enu_base) {
    Eigen::Map<Eigen::Vector3d>(fix_error_m.data()) = state.fix_error_m;
    Eigen::Map<Eigen::Vector3d>(wheel_errors.data()) = state.wheel_errors;
    std::size_t k = 0;
    for (int column = 0; column < state_errors; ++column)
        for (int row = 0; row <= column; ++row) covariance[k++] = state.covariance(row, column);
}

EarthState EarthStateRecord::state() const {
    EarthState state;
    state.T_enu_base = T_enu_base.pose();
    state.fix_error_m = Eigen::Map<const Eigen::Vector3d>(fix_error_m.data());
    state.wheel_errors = Eigen::Map<const Eigen::Vector3d>(wheel_errors.data());
    std::size_t k = 0;
    for (int column = 0; column < state_errors; ++column)
        for (int row = 0; row <= column; ++row)
            state.covariance(row, column) = state.covariance(column, row) = covariance[k++];
    return state;
}

SmootherStep::SmootherStep(std::size_t from_pose, const EarthState& before_, const Carried& carried)
    : pose(from_pose), before(before_), after(carried.after) {
    Eigen::Map<StateMatrix>(before_and_after.data()) = carried.before_and_after;
}

EarthState smoothed_before(const SmootherStep& step, const EarthState& smoothed_after) {
    const EarthState before = step.before.state(), after = step.after.state();
    // C = P(before, after) P(after, after)^-1
    const StateMatrix C = after.covariance.ldlt()
                              .solve(Eigen::Map<const StateMatrix>(step.before_and_after.data()).transpose())
                              .transpose();
    EarthState smoothed = moved_by(before, C * difference(smoothed_after, after));
    smoothed.covariance =
        before.covariance + C * (smoothed_after.covariance - after.covariance) * C.transpose();
    smoothed.covariance = (smoothed.covariance + smoothed.covariance.transpose()).eval() / 2;
    return smoothed;
}

}  // namespace loopline::fusion
