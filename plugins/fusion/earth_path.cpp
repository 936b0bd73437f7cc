#include "fusion/earth_path.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "least_squares/chi_square.h"

namespace loopline::fusion {
namespace {

constexpr double first_sigma_m = 100;  // nothing is known
/// The search's heading counts so many times less than it says: the filter uses the same fixes again.
constexpr double heading_sigma_factor = 5;
/// An odometry that has just begun to move errs by more than it says: what it goes by was seen from one
/// place.
constexpr double start_way_m = 3, start_sigma_m = 0.02;
/// Refused fixes that are right agree for so long.
constexpr double agreement_s = 3;
/// What is unknown again after a re-entry.
constexpr double re_entry_heading_rad = 0.1;
/// A fix so much older than the pose that is settled still serves.
constexpr double hardly_late_s = 0.01;
constexpr double interpolation_sigma_m = 0.003;  // of where the vehicle was between two poses
constexpr double seen_every_m = 0.3;             // way between fixes that the heading is sought by
constexpr std::size_t most_seen = 80;
constexpr double no_height_sigma_m = 1e3;
constexpr double slow_mps = 1;  // Doppler shifts tell no heading below

}  // namespace

const char* name_of(FixUse use) {
    switch (use) {
        case FixUse::used:
            return "used";
        case FixUse::no_position:
            return "no_position";
        case FixUse::before_path:
            return "before_path";
        case FixUse::after_path:
            return "after_path";
        case FixUse::late:
            return "late";
        case FixUse::off_the_path:
            return "off_the_path";
        case FixUse::heading_never_found:
            break;
    }
    return "heading_never_found";
}

void EarthPath::take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d& covariance) {
    double way_m = 0;
    if (poses_.empty())
        first_ns_ = stamp_ns;
    else
        way_m = poses_.back().way_m +
                (T_odom_base.translation_m - poses_.back().T_odom_base.translation_m).norm();
    poses_.push_back({stamp_ns, T_odom_base, covariance, way_m});
    if (committed_)
        ahead_ = predict(ahead_, motion_to(poses() - 1), fix_sigma_.correlation_s, fix_sigma_.correlated_m);
    use_waiting();
    if (committed_) settle_before(stamp_ns - std::llround(1e9 * settings_.late_s));
}

void EarthPath::take_fix(const gnss::GnssFix& fix) {
    if (!fix.is_usable()) return tally(fix, FixUse::no_position);
    if (!earth_) earth_.emplace(fix.antenna);
    waiting_.push_back(fix);
    use_waiting();
}

std::optional<EarthState> EarthPath::latest() const {
    return committed_ ? std::optional(ahead_) : std::nullopt;
}

/// From the pose before to this one, with the drift that the odometry does not tell.
Motion EarthPath::motion_to(std::size_t number) const {
    const PoseNode &a = pose(number - 1), &b = pose(number);
    Motion motion{a.stamp_ns, b.stamp_ns, a.T_odom_base.inverse() * b.T_odom_base, b.covariance};
    const double way_m = motion.T_from_to.translation_m.norm();
    if (way_m > 0 && b.way_m < start_way_m)
        motion.covariance.diagonal().head<3>().array() += start_sigma_m * start_sigma_m;
    motion.covariance.diagonal().head<3>().array() += settings_.drift_m * settings_.drift_m * way_m;
    motion.covariance.diagonal().tail<3>().array() += settings_.drift_rad * settings_.drift_rad * way_m;
    return motion;
}

/// The last pose that is not later.
std::size_t EarthPath::pose_before(StampNs stamp_ns) const {
    const auto after = std::upper_bound(poses_.begin(), poses_.end(), stamp_ns,
                                        [](StampNs t, const PoseNode& node) { return t < node.stamp_ns; });
    return dropped_ + static_cast<std::size_t>(after - poses_.begin()) - 1;
}

void EarthPath::tally(const gnss::GnssFix& fix, FixUse use) {
    ++count_[static_cast<std::size_t>(use)];
    if (tell_) tell_(fix, use);
}

void EarthPath::use_waiting() {
    while (!waiting_.empty() && !poses_.empty() && waiting_.front().stamp_ns <= poses_.back().stamp_ns) {
        const gnss::GnssFix fix = waiting_.front();
        waiting_.pop_front();
        use(fix);
    }
}

void EarthPath::use(const gnss::GnssFix& fix) {
    if (fix.stamp_ns < first_ns_) return tally(fix, FixUse::before_path);
    if (!committed_) return look_for_heading(fix);
    tally(fix, apply(fix));
    look_ahead();
}

/// Poses up to there are done with, whether a fix came or not.
void EarthPath::settle_before(StampNs stamp_ns) {
    while (*committed_ + 1 < poses() && pose(*committed_ + 1).stamp_ns <= stamp_ns) commit_next();
}

void EarthPath::commit_next() {
    Matrix9d F;
    const EarthState next =
        predict(state_, motion_to(*committed_ + 1), fix_sigma_.correlation_s, fix_sigma_.correlated_m, &F);
    steps_.push_back(SmootherStep(*committed_, state_, next, F));
    state_ = next;
    ++*committed_;
    poses_.pop_front();
    ++dropped_;
}

/// The state at the latest pose, after the one at `committed_` has changed.
void EarthPath::look_ahead() {
    ahead_ = state_;
    for (std::size_t number = *committed_ + 1; number < poses(); ++number)
        ahead_ = predict(ahead_, motion_to(number), fix_sigma_.correlation_s, fix_sigma_.correlated_m);
}

FixUse EarthPath::apply(const gnss::GnssFix& fix) {
    settle_before(fix.stamp_ns);
    if (seconds_between(fix.stamp_ns, pose(*committed_).stamp_ns) > hardly_late_s) return FixUse::late;
    SigmaOfFix sigma = sigma_of(fix, settings_.noise);
    if (!fix.has_height) sigma.white_m.z() = no_height_sigma_m;
    follow_fix_error(fix.quality, sigma);
    for (double& white_m : sigma.white_m) white_m = std::hypot(white_m, interpolation_sigma_m);

    const Moment then = moment(fix.stamp_ns);
    if (!update_place(fix, then.T_base_then, sigma.white_m)) return FixUse::off_the_path;
    update_velocity(fix, then);
    return FixUse::used;
}

/// From now on that of this kind of fix.
void EarthPath::follow_fix_error(gnss::FixQuality quality, const SigmaOfFix& sigma) {
    fix_sigma_ = sigma;
    if (process_of(quality) == process_) return;
    process_ = process_of(quality);
    Matrix9d F;
    const EarthState renewed = with_new_fix_error(state_, sigma.correlated_m, &F);
    steps_.push_back(SmootherStep(*committed_, state_, renewed, F));
    state_ = renewed;
}

EarthPath::Moment EarthPath::moment(StampNs stamp_ns) const {
    if (*committed_ + 1 >= poses()) return {};
    const Motion motion = motion_to(*committed_ + 1);
    return {motion.T_from_at(stamp_ns), log_se3(motion.T_from_to) * (1 / motion.duration_s())};
}

/// False if the fix can't be.
bool EarthPath::update_place(const gnss::GnssFix& fix, const Pose3& T_base_then,
                             const Eigen::Vector3d& white_m) {
    const Eigen::Vector3d p_enu_m = earth_->p_enu_m(fix.antenna);
    const auto innovation = [&] {
        return innovation_of_place(state_, T_base_then, fix.p_base_antenna_m, p_enu_m, white_m);
    };
    Innovation<3> place = innovation();
    if (place.square() > least_squares::chi_square_quantile(3, settings_.gate)) {
        if (!is_re_entry(fix.stamp_ns, place.off)) return false;
        doubt_the_path(place.off);
        place = innovation();
        ++re_entries_;
    }
    misfits_.clear();
    used_ns_ = fix.stamp_ns;
    sum_of_squares_ += place.square() / 3;
    ++squares_;
    state_ = updated(state_, place);
    return true;
}

/// What the fixes are off by becomes uncertainty, and a heading that has led there is in doubt.
void EarthPath::doubt_the_path(const Eigen::Vector3d& off_m) {
    state_.covariance.topLeftCorner<3, 3>() +=
        off_m * off_m.transpose() + off_m.squaredNorm() / 9 * Eigen::Matrix3d::Identity();
    state_.covariance(5, 5) += re_entry_heading_rad * re_entry_heading_rad;
}

/// By Doppler shifts, where the vehicle moves.
void EarthPath::update_velocity(const gnss::GnssFix& fix, const Moment& then) {
    if (!fix.speed_mps || !fix.course_rad || *fix.speed_mps < slow_mps) return;
    const Eigen::Vector3d v_base_mps =
        then.velocity.shift_m + then.velocity.turn_rad.cross(fix.p_base_antenna_m);
    if (v_base_mps.norm() < slow_mps) return;
    const Eigen::Vector2d v_enu_mps =
        *fix.speed_mps * Eigen::Vector2d(std::cos(*fix.course_rad), std::sin(*fix.course_rad));
    const Innovation<2> velocity = innovation_of_velocity(state_, then.T_base_then, v_base_mps, v_enu_mps,
                                                          settings_.noise.sigma_velocity_mps);
    if (velocity.square() < least_squares::chi_square_quantile(2, settings_.gate))
        state_ = updated(state_, velocity);
}

/// No fix was used for long, and those refused since the last one are off by a way that is steady or grows
/// steadily: then it is the estimate that is wrong.
bool EarthPath::is_re_entry(StampNs stamp_ns, const Eigen::Vector3d& off_m) {
    misfits_.push_back({stamp_ns, off_m});
    const auto n = static_cast<Eigen::Index>(misfits_.size());
    if (n < 5 || seconds_between(misfits_.front().stamp_ns, stamp_ns) < agreement_s ||
        seconds_between(used_ns_, stamp_ns) < settings_.re_entry_s)
        return false;
    Eigen::MatrixX2d when(n, 2);
    Eigen::MatrixX3d off(n, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
        const Misfit& misfit = misfits_[static_cast<std::size_t>(i)];
        when.row(i) << 1, seconds_between(misfits_.front().stamp_ns, misfit.stamp_ns);
        off.row(i) = misfit.off_m;
    }
    const Eigen::Matrix<double, 2, 3> line = (when.transpose() * when).ldlt().solve(when.transpose() * off);
    if ((off - when * line).squaredNorm() < off.squaredNorm() / 16) return true;
    misfits_.erase(misfits_.begin());
    return false;
}

void EarthPath::look_for_heading(const gnss::GnssFix& fix) {
    early_.push_back(fix);
    const std::size_t before = pose_before(fix.stamp_ns);
    Pose3 T_odom_then = pose(before).T_odom_base;
    if (before + 1 < poses()) T_odom_then = T_odom_then * motion_to(before + 1).T_from_at(fix.stamp_ns);
    const Eigen::Vector3d p_local_m = T_odom_then * fix.p_base_antenna_m;
    if (!seen_.empty() && (p_local_m - seen_.back().p_local_m).norm() < seen_every_m) return;
    if (seen_.size() >= most_seen) {  // every second one
        std::size_t kept = 0;
        for (std::size_t i = 0; i < seen_.size(); i += 2) seen_[kept++] = seen_[i];
        seen_.resize(kept);
    }
    SigmaOfFix sigma = sigma_of(fix, settings_.noise);
    for (double& white_m : sigma.white_m) white_m = std::hypot(white_m, start_sigma_m);
    seen_.push_back(
        {seconds_between(first_ns_, fix.stamp_ns), p_local_m, earth_->p_enu_m(fix.antenna), sigma});
    const auto found = find_heading(seen_);
    if (!found || found->sigma_rad > settings_.heading_sigma_rad || found->misfit > 4) return;
    heading_found_sigma_rad_ = found->sigma_rad;
    heading_way_m_ = pose(before).way_m;
    begin(found->T_enu_local);
}

/// The search gave the place to linearise at. All fixes since the first pose are used again, so the heading
/// begins less certain than the search has it, and the place with nothing.
void EarthPath::begin(const Pose3& T_enu_odom) {
    state_.T_enu_base = T_enu_odom * poses_.front().T_odom_base;
    Vector9d sigma;  // along the vehicle's axes
    sigma << Eigen::Vector3d::Constant(first_sigma_m), settings_.sigma_roll_rad, settings_.sigma_pitch_rad,
        heading_sigma_factor * heading_found_sigma_rad_, Eigen::Vector3d::Zero();
    state_.covariance = sigma.cwiseAbs2().asDiagonal();
    const Matrix6d R = turned_both(state_.T_enu_base.rotation);
    state_.covariance.topLeftCorner<6, 6>() = R * state_.covariance.topLeftCorner<6, 6>() * R.transpose();
    committed_ = 0;
    for (const gnss::GnssFix& fix : early_) tally(fix, apply(fix));
    early_ = {};
    seen_ = {};
    look_ahead();
}

std::vector<SmoothedPose> EarthPath::smoothed() {
    for (const gnss::GnssFix& fix : waiting_) tally(fix, FixUse::after_path);
    waiting_ = {};
    if (!committed_) {
        for (const gnss::GnssFix& fix : early_) tally(fix, FixUse::heading_never_found);
        return path_of_odometry();
    }
    settle_before(poses_.back().stamp_ns);
    std::vector<SmoothedPose> path(poses());
    EarthState smoothed = state_;
    path[*committed_] = {smoothed.T_enu_base, smoothed.covariance.topLeftCorner<6, 6>()};
    for (std::size_t i = steps_.size(); i-- > 0;) {
        const SmootherStep step = steps_[i];
        smoothed = smoothed_before(step, smoothed);
        path[step.pose] = {smoothed.T_enu_base, smoothed.covariance.topLeftCorner<6, 6>()};
    }
    return path;
}

std::vector<SmoothedPose> EarthPath::path_of_odometry() const {
    std::vector<SmoothedPose> path;
    Matrix6d covariance = Matrix6d::Zero();
    for (std::size_t number = 0; number < poses(); ++number) {
        const Pose3& T_odom_base = pose(number).T_odom_base;
        if (number > 0) {
            const Pose3& T_odom_before = pose(number - 1).T_odom_base;
            const Matrix6d F = carried_along(T_odom_base.translation_m - T_odom_before.translation_m),
                           R = turned_both(T_odom_before.rotation);
            covariance = F * covariance * F.transpose() + R * motion_to(number).covariance * R.transpose();
        }
        path.push_back({T_odom_base, covariance});
    }
    return path;
}

}  // namespace loopline::fusion
