#include "line_slam/wide_interval.h"

#include <cmath>

namespace loopline::line_slam {

bool WideInterval::add(const ScanMotion& motion) {
    const WheelTravel travel = wheel_travel(motion.T_previous_base, drive_.track_width_m);
    if (motion.duration_s > 0)
        speed_ = {travel.left_m / motion.duration_s, travel.right_m / motion.duration_s};
    const Regime measured = watch_.watch(speed_);
    regime_ = motion.commanded.value_or(measured);

    if (stretches_.empty() || stretches_.back().regime != regime_) {
        // The first stretch continues what was driven at the step: if it does not, that too is a change.
        if (parameters_.re_prediction && (!stretches_.empty() || regime_ != regime_at_step_))
            ++re_predictions_;
        stretches_.push_back({regime_, Pose2{}, 0});
    }
    Stretch& stretch = stretches_.back();
    stretch.T_from_to = stretch.T_from_to * motion.T_previous_base;
    stretch.duration_s += motion.duration_s;
    T_step_base_ = T_step_base_ * motion.T_previous_base;
    duration_s_ += motion.duration_s;
    way_m_ += motion.T_previous_base.translation().norm();
    ++scans_;
    return is_due();
}

bool WideInterval::is_due() const {
    if (scans_ >= parameters_.scans) return true;
    if (parameters_.kind == IntervalParameters::Kind::fixed) return false;
    if (way_m_ > parameters_.max_way_m || std::abs(T_step_base_.phi_rad) > parameters_.max_turn_rad)
        return true;
    double variance_m2 = 0;
    for (const MotionPiece& p : pieces()) variance_m2 += p.covariance(0, 0) + p.covariance(1, 1);
    return variance_m2 > parameters_.max_sigma_m * parameters_.max_sigma_m;
}

WheelTravel WideInterval::travel_at(const WheelSpeed& speed, double duration_s) const {
    return {speed.left_mps * duration_s, speed.right_mps * duration_s, 0};
}

MotionPiece WideInterval::piece(Regime regime, WheelTravel travel) const {
    const RegimeParameters& r = parameters_.regimes[static_cast<std::size_t>(regime)];
    MotionPiece p;
    p.covariance = travel_covariance(travel, drive_, r.sigma_left_m, r.sigma_right_m);
    travel.left_m *= 1 - r.slip_left;
    travel.right_m *= 1 - r.slip_right;
    p.travel = travel;
    return p;
}

std::vector<MotionPiece> WideInterval::pieces() const {
    const bool measured = parameters_.control == IntervalParameters::Control::measured;
    const auto commanded = [&](Regime regime) {
        return parameters_.regimes[static_cast<std::size_t>(regime)].commanded;
    };
    if (!parameters_.re_prediction) {
        // Eq. (3) over the whole interval, by the speeds when it began.
        const WheelSpeed& speed = measured ? speed_at_step_ : commanded(regime_at_step_);
        return {piece(regime_at_step_, travel_at(speed, duration_s_))};
    }
    std::vector<MotionPiece> pieces;
    for (const Stretch& s : stretches_)
        pieces.push_back(piece(s.regime, measured ? wheel_travel(s.T_from_to, drive_.track_width_m)
                                                  : travel_at(commanded(s.regime), s.duration_s)));
    return pieces;
}

void WideInterval::restart() {
    speed_at_step_ = speed_;
    regime_at_step_ = regime_;
    stretches_.clear();
    T_step_base_ = Pose2{};
    duration_s_ = way_m_ = 0;
    scans_ = 0;
}

}  // namespace loopline::line_slam
