#include "fusion/paper_path.h"

#include <algorithm>
#include <cmath>

namespace loopline::fusion {
namespace {

Vector6d sigmas(double shift_m, double turn_rad) {
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(shift_m), Eigen::Vector3d::Constant(turn_rad);
    return sigma;
}

/// Way from a time between two frames to the second of them, along the vehicle's axes there.
Eigen::Vector3d way_to_frame(StampNs from_ns, const Pose3& T_odom_from, StampNs to_ns, const Pose3& T_odom_to,
                             StampNs stamp_ns) {
    const double part = seconds_between(from_ns, stamp_ns) / seconds_between(from_ns, to_ns);
    const Pose3 T_odom_then = interpolate_se3(T_odom_from, T_odom_to, part);
    return T_odom_to.rotation.conjugate() * (T_odom_to.translation_m - T_odom_then.translation_m);
}

}  // namespace

void PaperPath::take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d&,
                          const std::optional<Twist2>& wheels) {
    if (frames_.empty()) first_ns_ = stamp_ns;
    if (!frames_.empty())
        way_m_ += (T_odom_base.translation_m - frames_.back().T_odom_base.translation_m).norm();
    frames_.push_back({stamp_ns, T_odom_base, wheels});
    if (begun_) ahead_ = next(ahead_, frames_[frames_.size() - 2], frames_.back(), nullptr);
    // A fix is used when the frame nearest to it is there.
    while (!waiting_.empty() && waiting_.front().stamp_ns <= stamp_ns) {
        const gnss::GnssFix fix = waiting_.front();
        waiting_.pop_front();
        use(fix);
    }
    if (begun_) settle_before(stamp_ns - std::llround(1e9 * settings_.late_s));
}

void PaperPath::take_fix(const gnss::GnssFix& fix, bool withheld) {
    if (!fix.is_usable()) return tally(fix, FixUse::no_position);
    if (withheld) return tally(fix, FixUse::withheld);
    if (!earth_) earth_.emplace(fix.antenna);
    if (!frames_.empty() && fix.stamp_ns <= frames_.back().stamp_ns) return use(fix);
    // One that is stamped far ahead lets those after it pass.
    const auto later = std::upper_bound(waiting_.begin(), waiting_.end(), fix.stamp_ns,
                                        [](StampNs t, const gnss::GnssFix& w) { return t < w.stamp_ns; });
    waiting_.insert(later, fix);
}

void PaperPath::use(const gnss::GnssFix& fix) {
    if (fix.stamp_ns < first_ns_) return tally(fix, FixUse::before_path);
    if (!begun_) return look_for_heading(fix);
    if (fix.stamp_ns < frames_.front().stamp_ns) return tally(fix, FixUse::late);
    const bool own_time = settings_.sync == Sync::interpolate;
    settle_before(fix.stamp_ns - (own_time ? 0 : std::llround(1e9 * settings_.sync_s)));
    if (frames_.size() < 2) return tally(fix, FixUse::late);
    const double to_next_s = seconds_between(fix.stamp_ns, frames_[1].stamp_ns);
    const bool in_time = own_time || std::abs(to_next_s) <= settings_.sync_s;
    const bool complete = frames_[1].wheels.has_value() || !settings_.wheels_are_there;
    if (!in_time || !complete) return tally(fix, FixUse::out_of_sync);
    settle_next(&fix);
    tally(fix, FixUse::used);
    ++fused_;
    look_ahead();
}

void PaperPath::settle_before(StampNs stamp_ns) {
    while (frames_.size() > 1 && frames_[1].stamp_ns <= stamp_ns) settle_next(nullptr);
}

void PaperPath::settle_next(const gnss::GnssFix* fix) {
    step_ = next(step_, frames_[0], frames_[1], fix);
    frames_.pop_front();
    set_aside(pose_of(step_));
}

/// Algorithm 3 and 2: prediction, then lidar, wheels and fix, one after the other. Both odometries are
/// relative: they tell a pose from the one that the filter was at.
PaperPath::Step PaperPath::next(const Step& before, const Frame& from, const Frame& to,
                                const gnss::GnssFix* fix) const {
    const Pose3 T_from_to = from.T_odom_base.inverse() * to.T_odom_base, T_enu_from = before.filter.pose();
    Step step = before;
    const Vector6d lidar = sigmas(settings_.lidar_m, settings_.lidar_rad);
    if (fix == nullptr) {
        step.filter.follow(T_from_to, lidar);
    } else {
        const Vector6d process = sigmas(settings_.process_m, settings_.process_rad);
        step.filter.predict(before.way_m, before.turn_rad, process.cwiseAbs2().asDiagonal());
        step.filter.observe(T_enu_from * T_from_to, {0, 1, 2, 3, 4, 5}, lidar);
        if (to.wheels)
            step.filter.observe(T_enu_from * in_space(*to.wheels), {0, 1, 5},
                                sigmas(settings_.wheels_m, settings_.wheels_rad));
        Pose3 T_enu_by_fix = step.filter.pose();
        Eigen::Vector3d from_antenna_m = -fix->p_base_antenna_m;
        if (settings_.sync == Sync::interpolate)
            from_antenna_m +=
                way_to_frame(from.stamp_ns, from.T_odom_base, to.stamp_ns, to.T_odom_base, fix->stamp_ns);
        T_enu_by_fix.translation_m = earth_->p_enu_m(fix->antenna) + T_enu_by_fix.rotation * from_antenna_m;
        const gnss::SigmaOfFix sigma = gnss::sigma_of(*fix, settings_.noise);
        Vector6d of_fix = Vector6d::Zero();
        for (int axis = 0; axis < 3; ++axis)
            of_fix[axis] = std::hypot(sigma.white_m[axis], sigma.correlated_m[axis]);
        if (fix->has_height)
            step.filter.observe(T_enu_by_fix, {0, 1, 2}, of_fix);
        else
            step.filter.observe(T_enu_by_fix, {0, 1}, of_fix);
    }
    const Pose3 moved = T_enu_from.inverse() * step.filter.pose();
    step.way_m = moved.translation_m.head<2>().norm() * (moved.translation_m.x() < 0 ? -1 : 1);
    step.turn_rad = moved.yaw_rad();
    return step;
}

void PaperPath::look_ahead() {
    ahead_ = step_;
    for (std::size_t i = 1; i < frames_.size(); ++i)
        ahead_ = next(ahead_, frames_[i - 1], frames_[i], nullptr);
}

Pose3 PaperPath::T_odom_at(StampNs stamp_ns) const {
    const auto after = std::upper_bound(frames_.begin(), frames_.end(), stamp_ns,
                                        [](StampNs t, const Frame& frame) { return t < frame.stamp_ns; });
    if (after == frames_.begin()) return after->T_odom_base;
    const Frame& before = *(after - 1);
    if (after == frames_.end()) return before.T_odom_base;
    return interpolate_se3(
        before.T_odom_base, after->T_odom_base,
        seconds_between(before.stamp_ns, stamp_ns) / seconds_between(before.stamp_ns, after->stamp_ns));
}

/// The paper starts by hand or on the axes of the grid; here as the other filter does (row C11), at the frame
/// at which that is known.
void PaperPath::look_for_heading(const gnss::GnssFix& fix) {
    early_.push_back(fix);
    const auto found = start_.see(
        seconds_between(first_ns_, fix.stamp_ns), T_odom_at(fix.stamp_ns) * fix.p_base_antenna_m,
        earth_->p_enu_m(fix.antenna), gnss::sigma_of(fix, settings_.noise), {settings_.heading_sigma_rad});
    if (!found) return;
    heading_ = {way_m_, found->sigma_rad};
    for (const gnss::GnssFix& early : early_) tally(early, FixUse::used);
    early_ = {};
    start_.clear();
    begun_ = true;
    Vector6d sigma = sigmas(1, settings_.heading_sigma_rad);
    const Matrix6d covariance = sigma.cwiseAbs2().asDiagonal();
    while (true) {
        step_.filter = PaperFilter(found->T_enu_local * frames_.front().T_odom_base, covariance);
        set_aside(pose_of(step_));
        if (frames_.size() == 1 || frames_[1].stamp_ns > fix.stamp_ns) break;
        frames_.pop_front();
    }
    look_ahead();
}

std::optional<PoseOnEarth> PaperPath::known() const {
    return begun_ ? std::optional(pose_of(ahead_)) : std::nullopt;
}

void PaperPath::set_aside(const PoseOnEarth& pose) {
    Done done;
    done.T_enu_base = Pose3Record(pose.T_enu_base);
    Eigen::Map<Matrix6d>(done.covariance.data()) = pose.covariance;
    done_.push_back(done);
}

std::vector<PoseOnEarth> PaperPath::finished() {
    for (const gnss::GnssFix& fix : waiting_) tally(fix, FixUse::after_path);
    for (const gnss::GnssFix& fix : early_) tally(fix, FixUse::heading_never_found);
    waiting_ = {};
    early_ = {};
    std::vector<PoseOnEarth> path;
    if (!begun_) {
        for (const Frame& frame : frames_) path.push_back({frame.T_odom_base});
        return path;
    }
    settle_before(frames_.back().stamp_ns);
    for (const Done done : done_)
        path.push_back({done.T_enu_base.pose(), Eigen::Map<const Matrix6d>(done.covariance.data())});
    return path;
}

}  // namespace loopline::fusion
