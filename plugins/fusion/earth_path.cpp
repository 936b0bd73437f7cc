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
constexpr double interpolation_sigma_m = 0.003;
constexpr double seen_every_m = 0.3;
constexpr std::size_t most_seen = 80;
constexpr double no_height_sigma_m = 1e3;
constexpr double slow_mps = 1;  // Doppler shifts tell no heading below

}  // namespace

void EarthPath::take_pose(StampNs stamp_ns, const Pose3& T_odom_base, const Matrix6d& covariance) {
    const double step_m =
        poses_.empty() ? 0 : (T_odom_base.translation_m - poses_.back().T_odom_base.translation_m).norm();
    poses_.push_back({stamp_ns, T_odom_base, covariance, poses_.empty() ? 0 : poses_.back().way_m + step_m});
    if (poses_.size() > 1 && committed_)
        ahead_ =
            predict(ahead_, motion_to(poses_.size() - 1), fix_sigma_.correlation_s, fix_sigma_.correlated_m);
    use_waiting();
    if (committed_) settle_before(stamp_ns - std::llround(1e9 * settings_.late_s));
}

void EarthPath::take_fix(const gnss::GnssFix& fix) {
    if (!fix.is_usable()) return tally(FixUse::no_position);
    if (!earth_) earth_.emplace(fix.antenna);
    waiting_.push_back(fix);
    use_waiting();
}

std::optional<EarthState> EarthPath::latest() const {
    return committed_ ? std::optional(ahead_) : std::nullopt;
}

/// From the pose before a node to it, with the drift that the odometry does not tell.
Motion EarthPath::motion_to(std::size_t node) const {
    const PoseNode &a = poses_[node - 1], &b = poses_[node];
    Motion motion{a.stamp_ns, b.stamp_ns, a.T_odom_base.inverse() * b.T_odom_base, b.covariance};
    const double way_m = motion.T_from_to.translation_m.norm();
    if (way_m > 0 && b.way_m < start_way_m)
        motion.covariance.diagonal().head<3>().array() += start_sigma_m * start_sigma_m;
    motion.covariance.diagonal().head<3>().array() += settings_.drift_m * settings_.drift_m * way_m;
    motion.covariance.diagonal().tail<3>().array() += settings_.drift_rad * settings_.drift_rad * way_m;
    return motion;
}

/// The last pose that is not later.
std::size_t EarthPath::node_before(StampNs stamp_ns) const {
    const auto after = std::upper_bound(poses_.begin(), poses_.end(), stamp_ns,
                                        [](StampNs t, const PoseNode& node) { return t < node.stamp_ns; });
    return static_cast<std::size_t>(after - poses_.begin()) - 1;
}

void EarthPath::use_waiting() {
    while (!waiting_.empty() && !poses_.empty() && waiting_.front().stamp_ns <= poses_.back().stamp_ns) {
        const gnss::GnssFix fix = waiting_.front();
        waiting_.pop_front();
        use(fix);
    }
}

void EarthPath::use(const gnss::GnssFix& fix) {
    if (fix.stamp_ns < poses_.front().stamp_ns) return tally(FixUse::before_path);
    if (!committed_) return look_for_heading(fix);
    tally(apply(fix));
    look_ahead();
}

/// Poses up to there are done with, whether a fix came or not.
void EarthPath::settle_before(StampNs stamp_ns) {
    while (*committed_ + 1 < poses_.size() && poses_[*committed_ + 1].stamp_ns <= stamp_ns) commit_next();
}

void EarthPath::commit_next() {
    Matrix9d F;
    const EarthState next =
        predict(state_, motion_to(*committed_ + 1), fix_sigma_.correlation_s, fix_sigma_.correlated_m, &F);
    steps_.push_back(SmootherStep(*committed_, state_, next, F));
    state_ = next;
    ++*committed_;
}

/// The state at the latest pose, after the one at `committed_` has changed.
void EarthPath::look_ahead() {
    ahead_ = state_;
    for (std::size_t node = *committed_ + 1; node < poses_.size(); ++node)
        ahead_ = predict(ahead_, motion_to(node), fix_sigma_.correlation_s, fix_sigma_.correlated_m);
}

FixUse EarthPath::apply(const gnss::GnssFix& fix) {
    settle_before(fix.stamp_ns);
    const PoseNode& node = poses_[*committed_];
    if (fix.stamp_ns < node.stamp_ns && seconds_between(fix.stamp_ns, node.stamp_ns) > 0.01)
        return FixUse::late;

    SigmaOfFix sigma = sigma_of(fix, settings_.noise);
    if (!fix.has_height) sigma.white_m.z() = no_height_sigma_m;
    if (const ErrorProcess process = process_of(fix.quality); process != process_) {
        Matrix9d F;
        const EarthState renewed = with_new_fix_error(state_, sigma.correlated_m, &F);
        steps_.push_back(SmootherStep(*committed_, state_, renewed, F));
        state_ = renewed;
        process_ = process;
    }
    fix_sigma_ = sigma;
    for (double& white_m : sigma.white_m) white_m = std::hypot(white_m, interpolation_sigma_m);

    Pose3 T_base_then;
    Eigen::Vector3d v_base_mps = Eigen::Vector3d::Zero();
    if (*committed_ + 1 < poses_.size()) {
        const Motion motion = motion_to(*committed_ + 1);
        T_base_then = motion.T_from_at(fix.stamp_ns);
        const Twist3 twist = log_se3(motion.T_from_to) * (1 / motion.duration_s());
        v_base_mps = twist.shift_m + twist.turn_rad.cross(fix.p_base_antenna_m);
    }
    const Eigen::Vector3d p_enu_m = earth_->p_enu_m(fix.antenna);
    Innovation<3> place =
        innovation_of_place(state_, T_base_then, fix.p_base_antenna_m, p_enu_m, sigma.white_m);
    const double gate = least_squares::chi_square_quantile(3, settings_.gate);
    if (place.square() > gate) {
        if (!is_re_entry(fix.stamp_ns, place.off)) return FixUse::off_the_path;
        state_.covariance.topLeftCorner<3, 3>() +=
            place.off * place.off.transpose() + place.off.squaredNorm() / 9 * Eigen::Matrix3d::Identity();
        state_.covariance(5, 5) += re_entry_heading_rad * re_entry_heading_rad;
        place = innovation_of_place(state_, T_base_then, fix.p_base_antenna_m, p_enu_m, sigma.white_m);
        ++re_entries_;
    }
    misfits_.clear();
    used_ns_ = fix.stamp_ns;
    sum_of_squares_ += place.square() / 3;
    ++squares_;
    state_ = updated(state_, place);
    if (fix.speed_mps && fix.course_rad && *fix.speed_mps > slow_mps && v_base_mps.norm() > slow_mps) {
        const Eigen::Vector2d v_enu_mps =
            *fix.speed_mps * Eigen::Vector2d(std::cos(*fix.course_rad), std::sin(*fix.course_rad));
        const Innovation<2> velocity = innovation_of_velocity(state_, T_base_then, v_base_mps, v_enu_mps,
                                                              settings_.noise.sigma_velocity_mps);
        if (velocity.square() < least_squares::chi_square_quantile(2, settings_.gate))
            state_ = updated(state_, velocity);
    }
    return FixUse::used;
}

/// Fixes that were all refused for long, and by a way that is steady or grows steadily: then it is the
/// estimate that is wrong.
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
    const std::size_t node = node_before(fix.stamp_ns);
    Pose3 T_odom_then = poses_[node].T_odom_base;
    if (node + 1 < poses_.size()) T_odom_then = T_odom_then * motion_to(node + 1).T_from_at(fix.stamp_ns);
    const Eigen::Vector3d p_local_m = T_odom_then * fix.p_base_antenna_m;
    if (!seen_.empty() && (p_local_m - seen_.back().p_local_m).norm() < seen_every_m) return;
    if (seen_.size() >= most_seen) {  // every second one
        std::size_t kept = 0;
        for (std::size_t i = 0; i < seen_.size(); i += 2) seen_[kept++] = seen_[i];
        seen_.resize(kept);
    }
    SigmaOfFix sigma = sigma_of(fix, settings_.noise);
    for (double& white_m : sigma.white_m) white_m = std::hypot(white_m, start_sigma_m);
    seen_.push_back({seconds_between(poses_.front().stamp_ns, fix.stamp_ns), p_local_m,
                     earth_->p_enu_m(fix.antenna), sigma});
    const auto found = find_heading(seen_);
    if (!found || found->sigma_rad > settings_.heading_sigma_rad || found->misfit > 4) return;
    heading_found_sigma_rad_ = found->sigma_rad;
    heading_way_m_ = poses_[node].way_m;
    begin(found->T_enu_local);
}

/// The search gave the place to linearise at; what is known begins with nothing, and all fixes are used once.
void EarthPath::begin(const Pose3& T_enu_odom) {
    state_.T_enu_base = T_enu_odom * poses_.front().T_odom_base;
    Vector9d sigma;  // along the vehicle's axes
    sigma << Eigen::Vector3d::Constant(first_sigma_m), settings_.sigma_roll_rad, settings_.sigma_pitch_rad,
        heading_sigma_factor * heading_found_sigma_rad_, Eigen::Vector3d::Zero();
    state_.covariance = sigma.cwiseAbs2().asDiagonal();
    const Matrix6d R = turned_both(state_.T_enu_base.rotation);
    state_.covariance.topLeftCorner<6, 6>() = R * state_.covariance.topLeftCorner<6, 6>() * R.transpose();
    committed_ = 0;
    for (const gnss::GnssFix& fix : early_) tally(apply(fix));
    early_ = {};
    seen_ = {};
    look_ahead();
}

std::vector<SmoothedPose> EarthPath::smoothed() {
    std::vector<SmoothedPose> path(poses_.size());
    if (!committed_) {
        count_[static_cast<std::size_t>(FixUse::heading_never_found)] = early_.size();
        Matrix6d covariance = Matrix6d::Zero();
        for (std::size_t i = 0; i < poses_.size(); ++i) {
            if (i > 0) {
                const Motion motion = motion_to(i);
                const Matrix6d F = carried_along(poses_[i].T_odom_base.translation_m -
                                                 poses_[i - 1].T_odom_base.translation_m),
                               R = turned_both(poses_[i - 1].T_odom_base.rotation);
                covariance = F * covariance * F.transpose() + R * motion.covariance * R.transpose();
            }
            path[i] = {poses_[i].T_odom_base, covariance};
        }
        return path;
    }
    settle_before(poses_.back().stamp_ns);
    EarthState smoothed = state_;
    path[*committed_] = {smoothed.T_enu_base, smoothed.covariance.topLeftCorner<6, 6>()};
    for (std::size_t i = steps_.size(); i-- > 0;) {
        const SmootherStep step = steps_[i];
        smoothed = smoothed_before(step, smoothed);
        path[step.pose] = {smoothed.T_enu_base, smoothed.covariance.topLeftCorner<6, 6>()};
    }
    return path;
}

}  // namespace loopline::fusion
