#include "line_slam/wide_interval.h"

#include <cmath>

#include "api/twist2.h"

namespace loopline::line_slam {

namespace {

WheelTravel travel_at(const WheelSpeed& speed, double duration_s) {
    return {speed.left_mps * duration_s, speed.right_mps * duration_s, 0};
}

}  // namespace

bool WideInterval::add(const ScanMotion& motion) {
    if (!begun_) T_step_odom_ = PreparedPose2(motion.T_odom_base.inverse());
    T_odom_base_ = motion.T_odom_base;
    T_step_previous_ = T_step_base_;
    T_step_base_ = T_step_odom_ * motion.T_odom_base;
    last_duration_s_ = motion.duration_s;
    const double way_m = (T_step_base_.translation() - T_step_previous_.translation()).norm();
    const double turn_rad = wrap_to_pi(T_step_base_.phi_rad - T_step_previous_.phi_rad);
    if (motion.duration_s > 0)
        watch_.watch(way_m / motion.duration_s, turn_rad * drive_.odometry_width_m() / motion.duration_s);
    regime_ = motion.commanded.value_or(watch_.regime());
    if (!begun_) regime_at_step_ = regime_;

    const Regime before = stretches_.empty() ? regime_at_step_ : stretches_.back().regime;
    if (parameters_.re_prediction && regime_ != before) ++re_predictions_;
    if (stretches_.empty() || regime_ != before) begin_stretch(before, motion);
    duration_s_ += motion.duration_s;
    way_m_ += way_m;
    ++scans_;
    const bool due = !begun_ || is_due();
    begun_ = true;
    return due;
}

/// Where the regime changed; what the wheels show, they show of the whole motion since the scan before.
void WideInterval::begin_stretch(Regime before, const ScanMotion& motion) {
    const double at = motion.commanded && regime_ != before ? motion.commanded_at : 0;
    if (stretches_.empty() && at > 0) stretches_.push_back({before, T_step_previous_, duration_s_});
    stretches_.push_back(
        {regime_, interpolate_se2(T_step_previous_, T_step_base_, at), duration_s_ + at * motion.duration_s});
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

WheelTravel WideInterval::without_slip(Regime regime, WheelTravel rolled) const {
    const RegimeParameters& r = parameters_.regimes[static_cast<std::size_t>(regime)];
    rolled.left_m *= 1 - r.slip_left;
    rolled.right_m *= 1 - r.slip_right;
    return rolled;
}

MotionPiece WideInterval::piece(Regime regime, const WheelTravel& rolled) const {
    const RegimeParameters& r = parameters_.regimes[static_cast<std::size_t>(regime)];
    return {without_slip(regime, rolled), travel_covariance(rolled, drive_, r.sigma_left_m, r.sigma_right_m)};
}

Eigen::Matrix3d WideInterval::noise_on(const Pose2& predicted, Regime regime) const {
    WheelTravel travel = wheel_travel(predicted, drive_.track_width_m);
    const RegimeParameters& r = parameters_.regimes[static_cast<std::size_t>(regime)];
    DriveParameters moving = drive_;
    moving.sigma_rest_m = 0;
    const Eigen::Matrix3d J = motion_jacobians(travel, drive_.track_width_m).travel;
    travel.left_m /= 1 - r.slip_left;
    travel.right_m /= 1 - r.slip_right;
    return J * travel_covariance(travel, moving, r.sigma_left_m, r.sigma_right_m) * J.transpose();
}

const WheelSpeed& WideInterval::commanded(Regime regime) const {
    return parameters_.regimes[static_cast<std::size_t>(regime)].commanded;
}

WheelTravel WideInterval::measured_travel(const Pose2& T_old_new) const {
    return wheel_travel(T_old_new, drive_.odometry_width_m());
}

template <class Take>
void WideInterval::each_driven(const Take& take) const {
    const bool measured = parameters_.control == IntervalParameters::Control::measured;
    for (std::size_t k = 0; k < stretches_.size(); ++k) {
        const Stretch& s = stretches_[k];
        const bool last = k + 1 == stretches_.size();
        const Pose2& T_step_to = last ? T_step_base_ : stretches_[k + 1].T_step_from;
        const double duration_s = (last ? duration_s_ : stretches_[k + 1].from_s) - s.from_s;
        // The first stretch begins at the step.
        const auto measured_here = [&] {
            return measured_travel(k == 0 ? T_step_to : s.T_step_from.inverse() * T_step_to);
        };
        take(DrivePiece{s.regime, measured ? measured_here() : travel_at(commanded(s.regime), duration_s),
                        duration_s});
    }
}

template <class Take>
void WideInterval::each_predicted(const Take& take) const {
    if (parameters_.re_prediction) {
        each_driven(take);
        return;
    }
    // Eq. (3) over the whole interval, by the speeds when it began.
    const bool measured = parameters_.control == IntervalParameters::Control::measured;
    const WheelSpeed& speed = measured ? speed_at_step_ : commanded(regime_at_step_);
    take(DrivePiece{regime_at_step_, travel_at(speed, duration_s_), duration_s_});
}

std::vector<MotionPiece> WideInterval::pieces() const {
    std::vector<MotionPiece> pieces;
    each_predicted([&](const DrivePiece& p) { pieces.push_back(piece(p.regime, p.rolled)); });
    return pieces;
}

Pose2 WideInterval::T_step_base_predicted(const WheelCalibration& calibration) const {
    Pose2 T_step_base;
    bool first = true;
    each_predicted([&](const DrivePiece& p) {
        const Pose2 T_piece = moved(without_slip(p.regime, p.rolled), drive_.track_width_m, calibration);
        T_step_base = first ? T_piece : T_step_base * T_piece;
        first = false;
    });
    return T_step_base;
}

std::vector<DrivePiece> WideInterval::drive_pieces() const {
    std::vector<DrivePiece> pieces;
    each_driven([&](const DrivePiece& p) { pieces.push_back(p); });
    return pieces;
}

void WideInterval::restart() {
    if (last_duration_s_ > 0) {
        const WheelTravel last = measured_travel(T_step_previous_.inverse() * T_step_base_);
        speed_at_step_ = {last.left_m / last_duration_s_, last.right_m / last_duration_s_};
    }
    regime_at_step_ = regime_;
    stretches_.clear();
    T_step_odom_ = PreparedPose2(T_odom_base_.inverse());
    T_step_base_ = T_step_previous_ = Pose2{};
    duration_s_ = way_m_ = 0;
    scans_ = 0;
}

}  // namespace loopline::line_slam
