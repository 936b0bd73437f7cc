#include "fusion/smoother.h"

#include "api/dense_algebra.h"

namespace loopline::fusion {

EarthStateRecord::EarthStateRecord(const EarthState& state) : T_enu_base(state.T_enu_base) {
    Eigen::Map<Eigen::Vector3d>(fix_error_m.data()) = state.fix_error_m;
    Eigen::Map<WheelErrors>(wheel_errors.data()) = state.wheel_errors;
    Eigen::Map<Eigen::Vector3d>(antenna_off_m.data()) = state.antenna_off_m;
    std::size_t k = 0;
    for (int column = 0; column < state_errors; ++column)
        for (int row = 0; row <= column; ++row) covariance[k++] = state.covariance(row, column);
}

EarthState EarthStateRecord::state() const {
    EarthState state;
    state.T_enu_base = T_enu_base.pose();
    state.fix_error_m = Eigen::Map<const Eigen::Vector3d>(fix_error_m.data());
    state.wheel_errors = Eigen::Map<const WheelErrors>(wheel_errors.data());
    state.antenna_off_m = Eigen::Map<const Eigen::Vector3d>(antenna_off_m.data());
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
    const Eigen::Map<const StateMatrix> before_and_after(step.before_and_after.data());
    const StateMatrix C = solved(after.covariance, before_and_after.transpose()).transpose();
    EarthState smoothed = moved_by(before, C * difference(smoothed_after, after));
    smoothed.covariance = before.covariance + propagated(C, smoothed_after.covariance - after.covariance);
    smoothed.covariance = (smoothed.covariance + smoothed.covariance.transpose()).eval() / 2;
    return smoothed;
}

}  // namespace loopline::fusion
