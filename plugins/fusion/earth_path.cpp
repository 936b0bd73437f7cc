#include "fusion/earth_path.h"

#include <algorithm>
#include <cmath>

#include "least_squares/chi_square.h"

namespace loopline::fusion {
namespace {

/// What is unknown again after a re-entry.
constexpr double re_entry_heading_rad = 0.1;
/// A fix so much older than the pose that is settled still serves.
constexpr double hardly_late_s = 0.01;
/// More than so many poses are not gone back.
constexpr std::size_t most_poses_since = 3000;
/// Nor is a path that rests on fixes of so many times [fusion] re_entry_s.
constexpr double rests_on_enough = 2;
constexpr double interpolation_sigma_m = 0.003;  // of where the vehicle was between two poses
/// Which direction an odometry leaves free, as along a tunnel, it knows no better than this.
constexpr double free_direction_rad = 0.005;
constexpr double nothing_known = 100;  // variance, m^2 or rad^2
constexpr double no_height_sigma_m = 1e3;
constexpr double slow_mps = 1;  // Doppler shifts tell no heading below

}  // namespace

EarthPath::EarthPath(const EarthPathSettings& settings) : settings_(settings) {
    ahead_.covariance.diagonal().segment<wheel_error_count>(wheel_errors_at) =
        settings.wheels.first.cwiseAbs2();
}

WheelErrors EarthPath::wheel_error_sigmas() const {
    return ahead_.covariance.diagonal().segment<wheel_error_count>(wheel_errors_at).cwiseSqrt();
}

void EarthPath::take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d& covariance,
                          const std::optional<Twist2>& wheels) {
    PoseNode node;
    node.stamp_ns = stamp_ns;
    node.T_odom_base = T_odom_base;
    node.covariance = covariance;
    node.wheels = wheels;
    std::swap(node.upright, upright_);
    if (!poses_.empty())
        node.way_m = poses_.back().way_m +
                     (T_odom_base.translation_m - poses_.back().T_odom_base.translation_m).norm();
    take(std::move(node));
}

void EarthPath::take_wheels(StampNs stamp_ns, const Twist2& told) {
    PoseNode node;
    node.stamp_ns = stamp_ns;
    node.wheels = told;
    node.by_wheels = true;
    if (!poses_.empty()) {
        node.T_odom_base = poses_.back().T_odom_base * in_space(told);
        node.way_m = poses_.back().way_m + std::hypot(told.forward_m, told.left_m);
    }
    take(std::move(node));
}

void EarthPath::take(PoseNode node) {
    const StampNs stamp_ns = node.stamp_ns;
    const bool first = poses_.empty();
    poses_.push_back(std::move(node));
    if (first) {
        first_ns_ = stamp_ns;
        ahead_.T_enu_base = poses_.back().T_odom_base;
    } else {
        const std::size_t number = poses() - 1;
        const StateAndMotion both = motion_to(number, ahead_, &wheel_use_);
        latest_motion_ = {both.T_from_to, both.of_motion()};
        ahead_ = carry(both, duration_s(number), fix_process_, settings_.wheels).after;
        if (committed_) ahead_ = upright(number, ahead_);
    }
    use_waiting();
    if (committed_) settle_before(stamp_ns - std::llround(1e9 * settings_.late_s));
}

void EarthPath::take_fix(const gnss::GnssFix& fix, bool withheld) {
    if (!fix.is_usable()) return judge({fix, withheld}, FixUse::no_position);
    if (!earth_) earth_.emplace(fix.antenna);
    // One that is stamped far ahead lets those after it pass.
    const auto later = std::upper_bound(waiting_.begin(), waiting_.end(), fix.stamp_ns,
                                        [](StampNs t, const WaitingFix& w) { return t < w.fix.stamp_ns; });
    waiting_.insert(later, {fix, withheld});
    use_waiting();
}

std::optional<EarthState> EarthPath::latest() const {
    return committed_ ? std::optional(ahead_) : std::nullopt;
}

std::optional<PoseOnEarth> EarthPath::known() const {
    if (!committed_) return std::nullopt;
    return PoseOnEarth{ahead_.T_enu_base, ahead_.covariance.topLeftCorner<6, 6>()};
}

/// From the pose before to this one.
double EarthPath::duration_s(std::size_t number) const {
    return seconds_between(pose(number - 1).stamp_ns, pose(number).stamp_ns);
}

double EarthPath::speed_mps(std::size_t number) const {
    return (pose(number).way_m - pose(number - 1).way_m) / duration_s(number);
}

/// Where the odometry's surroundings leave a direction free, each motion tells with an error of its own which
/// one that is, and which turn goes with it. Taken at its word, a centimetre that is missed across would be
/// made up for by tens of metres to and fro along directions that differ by as much.
void EarthPath::forget_what_goes_with_free_ways(Matrix6d& covariance) const {
    const double shift_m2 = covariance.topLeftCorner<3, 3>().trace();
    if (shift_m2 < settings_.held_m * settings_.held_m) return;
    covariance.topRightCorner<3, 3>().setZero();
    covariance.bottomLeftCorner<3, 3>().setZero();
    covariance.diagonal().head<3>().array() += free_direction_rad * free_direction_rad * shift_m2;
}

/// The odometry's motion with the drift that it does not tell.
Motion EarthPath::odometry_to(std::size_t number) const {
    const PoseNode &a = pose(number - 1), &b = pose(number);
    Motion motion{a.T_odom_base.inverse() * b.T_odom_base, b.covariance};
    forget_what_goes_with_free_ways(motion.covariance);
    const double way_m = motion.T_from_to.translation_m.norm();
    motion.covariance.diagonal().head<3>().array() += settings_.drift_m * settings_.drift_m * way_m;
    motion.covariance.diagonal().tail<3>().array() += settings_.drift_rad * settings_.drift_rad * way_m;
    return motion;
}

Motion EarthPath::without_what_wheels_told(Motion motion) const {
    for (const Eigen::Index k : {0, 1, 5}) {
        const double held = k < 3 ? settings_.held_m : settings_.held_rad;
        if (motion.covariance(k, k) > held * held) motion.covariance(k, k) += nothing_known;
    }
    return motion;
}

/// By all who tell of it. Wheels that say something else than the odometry have slipped.
StateAndMotion EarthPath::motion_to(std::size_t number, const EarthState& from, WheelUse* use) const {
    const PoseNode& node = pose(number);
    if (node.by_wheels) return with_wheels(from, *node.wheels, settings_.wheels);
    if (!node.wheels) return with_odometry(from, odometry_to(number));
    const Motion odometry = odometry_to(number);
    const StateAndMotion held = with_odometry(from, without_what_wheels_told(odometry));
    const WheelInnovation wheels = innovation_of_wheels(held, *node.wheels, settings_.wheels);
    const double square = wheels.square();
    const bool slipped = square > least_squares::chi_square_quantile(3, settings_.slip_gate);
    if (use != nullptr) {
        ++(slipped ? use->slipped : use->used);
        use->sum_of_squares += slipped ? 0 : square;
    }
    // What the odometry may have from wheels that slipped is still more than nothing.
    return slipped ? with_odometry(from, odometry) : updated(held, wheels);
}

EarthState EarthPath::predict(std::size_t number, const EarthState& from) const {
    return upright(number,
                   carry(motion_to(number, from), duration_s(number), fix_process_, settings_.wheels).after);
}

/// The state at a pose, by what is upright there; walls that lean more than all uncertainty explains say
/// nothing.
EarthState EarthPath::upright(std::size_t number, const EarthState& state) const {
    if (!pose(number).upright || settings_.sigma_upright_rad == 0) return state;
    const auto& [R_level_odom, covariance_rad2] = *pose(number).upright;
    const Eigen::Quaterniond R_base_odom = pose(number).T_odom_base.rotation.conjugate();
    const Eigen::Vector3d up_base = R_base_odom * (R_level_odom.conjugate() * Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d ahead =
        state.T_enu_base.rotation * (R_base_odom * (R_level_odom.conjugate() * Eigen::Vector3d::UnitX()));
    const double heading_rad = std::atan2(ahead.y(), ahead.x());
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(heading_rad).toRotationMatrix();
    Eigen::Matrix2d in_enu_rad2 = R * covariance_rad2 * R.transpose();
    in_enu_rad2.diagonal().array() += settings_.sigma_upright_rad * settings_.sigma_upright_rad;
    const Innovation<2> innovation = innovation_of_upright(state, up_base, in_enu_rad2);
    if (innovation.square() > least_squares::chi_square_quantile(2, settings_.gate)) return state;
    return updated(state, innovation);
}

/// The last pose that is not later.
std::size_t EarthPath::pose_before(StampNs stamp_ns) const {
    const auto after = std::upper_bound(poses_.begin(), poses_.end(), stamp_ns,
                                        [](StampNs t, const PoseNode& node) { return t < node.stamp_ns; });
    return dropped_ + static_cast<std::size_t>(after - poses_.begin()) - 1;
}

/// Where the odometry has the vehicle at a time from that pose on.
Pose3 EarthPath::T_odom_at(std::size_t before, StampNs stamp_ns) const {
    if (before + 1 >= poses()) return pose(before).T_odom_base;
    return interpolate_se3(pose(before).T_odom_base, pose(before + 1).T_odom_base,
                           seconds_between(pose(before).stamp_ns, stamp_ns) / duration_s(before + 1));
}

void EarthPath::use_waiting() {
    while (!waiting_.empty() && !poses_.empty() && waiting_.front().fix.stamp_ns <= poses_.back().stamp_ns) {
        const WaitingFix waiting = waiting_.front();
        waiting_.pop_front();
        use(waiting);
    }
}

void EarthPath::use(const WaitingFix& waiting) {
    const gnss::GnssFix& fix = waiting.fix;
    if (fix.stamp_ns < first_ns_) return judge(waiting, FixUse::before_path);
    if (waiting.withheld) {
        if (committed_) look_at_withheld(fix);
        return judge(waiting, FixUse::withheld);
    }
    if (!committed_) return look_for_heading(fix);
    judge(waiting, apply(fix));
    if (re_entry_.rests_on_s() > rests_on_enough * settings_.re_entry_s) {
        weigh_latest_re_entry();
        leave_footholds();
    }
    look_ahead();
}

/// Poses up to there are done with, whether a fix came or not.
void EarthPath::settle_before(StampNs stamp_ns) {
    while (*committed_ + 1 < poses() && pose(*committed_ + 1).stamp_ns <= stamp_ns) commit_next();
}

void EarthPath::commit_next() {
    const std::size_t number = *committed_ + 1;
    const StateAndMotion both = motion_to(number, state_);
    const Carried carried = carry(both, duration_s(number), fix_process_, settings_.wheels);
    add_step(SmootherStep(*committed_, both.state, carried));
    state_ = upright(number, carried.after);
    ++*committed_;
    for (Foothold& foothold : footholds_) foothold.without = predict(number, foothold.without);
    const auto first = [&] { return footholds_.empty() ? *committed_ : footholds_.front().committed; };
    if (!goes_back_ && *committed_ - first() > most_poses_since) leave_footholds();
    for (; dropped_ < first(); ++dropped_) poses_.pop_front();
}

void EarthPath::add_step(const SmootherStep& step) {
    (footholds_.empty() ? steps_ : recent_steps_).push_back(step);
}

/// The state at the latest pose, after the one at `committed_` has changed.
void EarthPath::look_ahead() {
    ahead_ = state_;
    for (std::size_t number = *committed_ + 1; number < poses(); ++number) ahead_ = predict(number, ahead_);
}

FixUse EarthPath::apply(const gnss::GnssFix& fix) {
    settle_before(fix.stamp_ns);
    if (seconds_between(fix.stamp_ns, pose(*committed_).stamp_ns) > hardly_late_s) return FixUse::late;
    PresentFix seen{fix, gnss::sigma_of(fix, settings_.noise), {}};
    if (!fix.has_height) seen.sigma.white_m.z() = no_height_sigma_m;
    follow_fix_error(fix.quality, seen.sigma);
    for (double& white_m : seen.sigma.white_m) white_m = std::hypot(white_m, interpolation_sigma_m);

    seen.then = moment(fix.stamp_ns);
    double off_m = 0;
    const Placed placed = update_place(seen, off_m);
    if (placed == Placed::fix_is_off) return FixUse::off_the_path;
    if (placed == Placed::path_was_wrong) {
        goes_back_ = true;
        go_back(seen, off_m);
        const FixUse use = apply(fix);
        goes_back_ = false;
        return use;
    }
    update_velocity(fix, seen.then);
    const Pose3& T_base_then = seen.then.T_base_then;
    used_ = {state_.T_enu_base * T_base_then, T_odom_at(*committed_, fix.stamp_ns),
             pose(*committed_).way_m + T_base_then.translation_m.norm()};
    return FixUse::used;
}

/// From now on that of this kind of fix.
void EarthPath::follow_fix_error(gnss::FixQuality quality, const gnss::SigmaOfFix& sigma) {
    fix_process_ = {sigma.correlation_s, sigma.correlated_m};
    if (gnss::process_of(quality) == process_) return;
    process_ = gnss::process_of(quality);
    const Carried renewed = with_new_fix_error(state_, sigma.correlated_m);
    add_step(SmootherStep(*committed_, state_, renewed));
    state_ = renewed.after;
}

EarthPath::Moment EarthPath::moment(StampNs stamp_ns) const {
    const std::size_t next = *committed_ + 1;
    if (next >= poses()) return {};
    const Pose3 T_from_to = motion_to(next, state_).T_from_to;
    const Twist3 velocity = log_se3(T_from_to) * (1 / duration_s(next));
    return {exp_se3(velocity * seconds_between(pose(*committed_).stamp_ns, stamp_ns)), velocity,
            pose(next).by_wheels};
}

Innovation<3> EarthPath::innovation_of(const PresentFix& seen, const EarthState& state) const {
    const auto& [fix, sigma, then] = seen;
    Innovation<3> place = innovation_of_place(state, then.T_base_then, fix.p_base_antenna_m,
                                              earth_->p_enu_m(fix.antenna), sigma.white_m);
    const Eigen::Vector3d by_latency_m =
        settings_.sigma_latency_s *
        (state.T_enu_base.rotation * (then.T_base_then.rotation * then.of_antenna_mps(fix.p_base_antenna_m)));
    place.covariance += by_latency_m * by_latency_m.transpose();
    return place;
}

bool EarthPath::passes(const Innovation<3>& place) const {
    return place.square() <= least_squares::chi_square_quantile(3, settings_.gate);
}

EarthPath::Placed EarthPath::update_place(const PresentFix& seen, double& off_m) {
    const gnss::GnssFix& fix = seen.fix;
    const double white_m =
        std::hypot(seen.sigma.white_m.x(), settings_.sigma_latency_s * seen.then.velocity.shift_m.norm());
    const ReEntry::Fix judged{fix.stamp_ns, pose(*committed_).way_m,
                              std::hypot(white_m, seen.sigma.correlated_m.x()), white_m,
                              pose(*committed_).by_wheels};
    Innovation<3> place = innovation_of(seen, state_);
    off_m = place.off.norm();
    if (!passes(place)) {
        const ReEntry before = re_entry_;
        const auto verdict = re_entry_.refused(judged, place.off, settings_.re_entry_s);
        const bool can_go_back = !footholds_.empty() && !goes_back_,
                   was_wrong = can_go_back && (verdict == ReEntry::Verdict::path_was_wrong ||
                                               others_agree_without(seen, off_m));
        if (verdict == ReEntry::Verdict::path_holds && !was_wrong) return Placed::fix_is_off;
        ++re_entries_;
        if (was_wrong) return Placed::path_was_wrong;
        gain_foothold(before);
        if (verdict == ReEntry::Verdict::contradiction) remember_contradiction(seen, off_m);
        doubt_the_path(place.off, judged.way_m - used_.way_m);
        place = innovation_of(seen, state_);
    }
    for (Foothold& foothold : footholds_) foothold.agreeing = 0;
    re_entry_.used(judged, settings_.re_entry_s);
    used_ns_ = fix.stamp_ns;
    sum_of_squares_ += place.square() / 3;
    ++squares_;
    state_ = updated(state_, place);
    return Placed::by_fix;
}

/// What the fixes are off by becomes uncertainty, and so does an attitude that has led there within `way_m`.
void EarthPath::doubt_the_path(const Eigen::Vector3d& off_m, double way_m) {
    const double lean_rad = std::min(re_entry_heading_rad, std::abs(off_m.z()) / std::max(1.0, way_m));
    state_.covariance.diagonal().segment<2>(3).array() += lean_rad * lean_rad;
    state_.covariance.topLeftCorner<3, 3>() +=
        off_m * off_m.transpose() + off_m.squaredNorm() / 9 * Eigen::Matrix3d::Identity();
    state_.covariance(5, 5) += re_entry_heading_rad * re_entry_heading_rad;
}

/// By Doppler shifts, where the vehicle moves.
void EarthPath::update_velocity(const gnss::GnssFix& fix, const Moment& then) {
    if (!fix.speed_mps || !fix.course_rad || *fix.speed_mps < slow_mps) return;
    const Eigen::Vector3d v_base_mps = then.of_antenna_mps(fix.p_base_antenna_m);
    if (v_base_mps.norm() < slow_mps) return;
    const Eigen::Vector2d v_enu_mps =
        *fix.speed_mps * Eigen::Vector2d(std::cos(*fix.course_rad), std::sin(*fix.course_rad));
    const Innovation<2> velocity = innovation_of_velocity(
        state_, then.T_base_then, v_base_mps, then.by_wheels, v_enu_mps, settings_.noise.sigma_velocity_mps);
    if (velocity.square() < least_squares::chi_square_quantile(2, settings_.gate))
        state_ = updated(state_, velocity);
}

std::vector<PoseOnEarth> EarthPath::finished() {
    weigh_latest_re_entry();
    leave_footholds();
    for (const WaitingFix& waiting : waiting_) tally(waiting.fix, FixUse::after_path);
    waiting_ = {};
    if (!committed_) {
        for (const gnss::GnssFix& fix : early_) tally(fix, FixUse::heading_never_found);
        early_ = {};
        return path_of_odometry();
    }
    settle_before(poses_.back().stamp_ns);
    std::vector<PoseOnEarth> path(poses());
    EarthState smoothed = state_;
    path[*committed_] = {smoothed.T_enu_base, smoothed.covariance.topLeftCorner<6, 6>()};
    for (std::size_t i = steps_.size(); i-- > 0;) {
        const SmootherStep step = steps_[i];
        smoothed = smoothed_before(step, smoothed);
        path[step.pose] = {smoothed.T_enu_base, smoothed.covariance.topLeftCorner<6, 6>()};
    }
    judge_gaps(path);
    return path;
}

std::vector<PoseOnEarth> EarthPath::path_of_odometry() const {
    std::vector<PoseOnEarth> path;
    Matrix6d covariance = Matrix6d::Zero();
    for (std::size_t number = 0; number < poses(); ++number) {
        const Pose3& T_odom_base = pose(number).T_odom_base;
        if (number > 0) {
            const Matrix6d of_motion = pose(number).by_wheels
                                           ? noise_of(*pose(number).wheels, settings_.wheels)
                                           : odometry_to(number).covariance;
            covariance = inertial::grown(covariance, pose(number - 1).T_odom_base, T_odom_base, of_motion);
        }
        path.push_back({T_odom_base, covariance});
    }
    return path;
}

}  // namespace loopline::fusion
