#include "simulation/vehicle.h"

#include <cmath>

namespace loopline::simulation {

WheelPair Vehicle::commanded_mps(const VehicleSettings& s, Regime regime) {
    switch (regime) {
        case Regime::left:
            return {s.turn_inner_mps, s.turn_outer_mps};
        case Regime::right:
            return {s.turn_outer_mps, s.turn_inner_mps};
        case Regime::straight:
            break;
    }
    return {s.straight_mps, s.straight_mps};
}

/// Every turn slips by itself, as the wheels and the castors happen to stand.
void Vehicle::enter(Regime regime) {
    regime_ = regime;
    moving_ = true;
    if (regime == Regime::straight) {
        slip_ = {settings_.slip_straight, settings_.slip_straight};
        sigma_wheel_m_ = settings_.sigma_straight_m;
        return;
    }
    const double inner = settings_.slip_turn_inner + random_.normal(settings_.sigma_slip_turn);
    slip_ = regime == Regime::left ? WheelPair{inner, settings_.slip_turn_outer}
                                   : WheelPair{settings_.slip_turn_outer, inner};
    sigma_wheel_m_ = settings_.sigma_turn_m;
}

/// A first-order lag behind a command that wanders (an Ornstein-Uhlenbeck process).
double Vehicle::rim_way_m(double commanded_mps, double& speed_mps, double& wander) {
    const double keep = settings_.wander_s > 0 ? std::exp(-step_s_ / settings_.wander_s) : 0;
    wander = keep * wander + random_.normal(settings_.wander * std::sqrt(1 - keep * keep));
    const double follow = settings_.wheel_lag_s > 0 ? 1 - std::exp(-step_s_ / settings_.wheel_lag_s) : 1;
    speed_mps += follow * (commanded_mps * (1 + wander) - speed_mps);
    return speed_mps * step_s_;
}

VehicleStep Vehicle::step(Regime commanded) {
    if (!moving_ || commanded != regime_) enter(commanded);
    const WheelPair wanted_mps = commanded_mps(settings_, commanded);
    VehicleStep step;
    step.rim_m.left = rim_way_m(wanted_mps.left, speed_mps_.left, wander_.left);
    step.rim_m.right = rim_way_m(wanted_mps.right, speed_mps_.right, wander_.right);

    // Random ways whose variances grow in proportion to the way that was gone.
    const auto over_ground_m = [this](double rim_m, double slip) {
        return rim_m * (1 - slip) + random_.normal(sigma_wheel_m_ * std::sqrt(std::abs(rim_m)));
    };
    const double left_m = over_ground_m(step.rim_m.left, slip_.left);
    const double right_m = over_ground_m(step.rim_m.right, slip_.right);
    step.motion.forward_m = (right_m + left_m) / 2;
    step.motion.turn_rad = (right_m - left_m) / settings_.track_width_m;
    step.motion.left_m = random_.normal(settings_.sigma_side_m * std::sqrt(std::abs(step.motion.forward_m)));
    if (random_.chance(settings_.bumps_hz * step_s_))
        step.motion.turn_rad += random_.normal(settings_.sigma_bump_rad);
    return step;
}

}  // namespace loopline::simulation
