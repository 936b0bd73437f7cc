#include "grid_slam/inertial_navigation.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "api/twist2.h"
#include "inertial/rotation_vector.h"

namespace loopline::grid_slam {
namespace {

/// A reading between two others.
inertial::ImuSample between(const inertial::ImuSample& a, const inertial::ImuSample& b, StampNs stamp_ns) {
    const double span_s = seconds_between(a.stamp_ns, b.stamp_ns),
                 u = span_s > 0 ? seconds_between(a.stamp_ns, stamp_ns) / span_s : 0;
    return {stamp_ns, (1 - u) * a.omega_base_radps + u * b.omega_base_radps,
            (1 - u) * a.specific_force_base_mps2 + u * b.specific_force_base_mps2};
}

/// Variance of a turn by what the gyro's scale is wrong: in proportion to the turn, so that each step bears
/// as much as makes the sum right over a corner.
double variance_of_turn(const InertialSettings& settings, double turn_rad) {
    const double turn = std::abs(turn_rad);
    return settings.sigma_turn * settings.sigma_turn * turn * (turn + settings.corner_rad);
}

/// What speed and gyro get wrong within a step, on (x, y, phi) along the axes of the map.
Eigen::Matrix3d error_of_step(const inertial::ErrorStateFilter& filter, const InertialSettings& settings,
                              double duration_s, double turn_rad) {
    const auto& P = filter.covariance();
    const double dt = std::max(duration_s, 1e-3);
    // Errors that last make a way that grows with the time, where those of independent steps grow with its
    // root: each step bears as much as makes the sum right over a time in which they last.
    const double speed_s2 = dt * (dt + 2 * settings.speed_lasts_s),
                 bias_s2 = dt * (dt + 2 * settings.bias_lasts_s);
    Eigen::Matrix3d error = Eigen::Matrix3d::Zero();
    error.topLeftCorner<2, 2>() =
        P.block<2, 2>(inertial::velocity_error, inertial::velocity_error) * speed_s2 +
        std::pow(settings.sigma_speed_mps * dt, 2) * Eigen::Matrix2d::Identity();
    error(2, 2) = P(inertial::gyro_bias_error + 2, inertial::gyro_bias_error + 2) * bias_s2 +
                  std::pow(settings.noise.gyro.density_radps_sqrt_hz, 2) * dt +
                  variance_of_turn(settings, turn_rad) + 1e-9;
    return error;
}

/// State and covariance as seen after the map was moved.
void move_filter(inertial::ErrorStateFilter& filter, const Pose2& T_new_old) {
    inertial::NavigationState state = filter.state();
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(T_new_old.phi_rad, Eigen::Vector3d::UnitZ()));
    state.p_map_m = turn * state.p_map_m + Eigen::Vector3d(T_new_old.x_m, T_new_old.y_m, 0);
    state.v_map_mps = turn * state.v_map_mps;
    state.q_map_base = (turn * state.q_map_base).normalized();
    inertial::ErrorMatrix turns = inertial::ErrorMatrix::Identity();
    for (const int part : {inertial::position_error, inertial::velocity_error, inertial::attitude_error})
        turns.block<3, 3>(part, part) = turn.toRotationMatrix();
    filter.start(state, turns * filter.covariance() * turns.transpose());
}

/// The gyro's scale is not one of the errors that are estimated, and would pass for its bias after a corner.
void doubt_the_turn(inertial::ErrorStateFilter& filter, const InertialSettings& settings, double turn_rad) {
    inertial::ErrorMatrix P = filter.covariance();
    P(inertial::attitude_error + 2, inertial::attitude_error + 2) += variance_of_turn(settings, turn_rad);
    filter.start(filter.state(), P);
}

/// The map begins anew at the vehicle, and errs with it: position and heading are those of the map from now
/// on, and the velocity errs by what its direction does against that heading.
void begin_map(inertial::ErrorStateFilter& filter) {
    const Eigen::Vector3d v = filter.state().v_map_mps;
    constexpr int x = inertial::position_error, y = x + 1, heading = inertial::attitude_error + 2;
    inertial::ErrorMatrix since = inertial::ErrorMatrix::Identity();
    since(inertial::velocity_error, heading) = v.y();
    since(inertial::velocity_error + 1, heading) = -v.x();
    for (const int part : {x, y, heading}) since(part, part) = 0;
    inertial::ErrorMatrix P = since * filter.covariance() * since.transpose();
    constexpr double sigma_m = 1e-3, sigma_rad = 1e-4;  // not zero, which no filter likes
    P(x, x) = P(y, y) = sigma_m * sigma_m;
    P(heading, heading) = sigma_rad * sigma_rad;
    filter.start(filter.state(), P);
}

inertial::PlanarInformation without_the_map_noise(const ForwardMatch& match,
                                                  const Eigen::Matrix3d& map_noise) {
    // Directions that the scan does not hold have no information, and stay without.
    const Eigen::Matrix3d doubt = (Eigen::Matrix3d::Identity() + match.information * map_noise).inverse();
    return {match.T_map_base, doubt * match.information, doubt * match.gradient};
}

}  // namespace

InertialNavigation::InertialNavigation(const InertialSettings& settings)
    : settings_(settings),
      mechanisation_{settings.gravity_mps2},
      filter_(mechanisation_, settings.noise),
      window_(settings.alignment.duration_s) {}

void InertialNavigation::add(const inertial::ImuSample& sample, const Eigen::Vector3d& p_base_imu_m) {
    const StampNs newest_ns = !samples_.empty() ? samples_.back().stamp_ns
                              : latest_         ? latest_->stamp_ns
                                                : sample.stamp_ns - 1;
    if (sample.stamp_ns <= newest_ns) {
        ++backward_;
        return;
    }
    place_.p_base_imu_m = p_base_imu_m;
    if (!first_ns_) first_ns_ = sample.stamp_ns;
    if (settings_.keep_readings) readings_.push_back(sample);
    samples_.push_back(sample);
}

/// The reading at a time, which the filter then stands at; those before it are used up.
void InertialNavigation::propagate(StampNs stamp_ns) {
    while (!samples_.empty()) {
        const bool whole = samples_.front().stamp_ns <= stamp_ns;
        // Up to the scan itself, between two readings; after the last one the last one holds.
        const inertial::ImuSample next = whole     ? samples_.front()
                                         : latest_ ? between(*latest_, samples_.front(), stamp_ns)
                                                   : samples_.front();
        if (latest_ && next.stamp_ns <= latest_->stamp_ns) {
            if (!whole) return;
            samples_.pop_front();
            continue;
        }
        if (!latest_ && !whole) return;
        if (aligned_ && latest_) filter_.predict_forward(*latest_, next);
        if (!aligned_ && whole) window_.add(next);
        latest_ = next;
        if (!whole) return;
        samples_.pop_front();
    }
    if (latest_ && latest_->stamp_ns < stamp_ns) {
        inertial::ImuSample held = *latest_;
        held.stamp_ns = stamp_ns;
        if (aligned_) filter_.predict_forward(*latest_, held);
        latest_ = held;
    }
}

/// Starts the filter where the vehicle is now.
void InertialNavigation::try_to_align() {
    if (!latest_ || !scan_ns_) return;
    const inertial::ImuMean mean = window_.mean();
    inertial::Alignment alignment = inertial::align(mean, T_map_base_, mechanisation_, settings_.alignment);
    alignment_status_ = alignment.status;
    const bool overdue = seconds_between(*first_ns_, latest_->stamp_ns) > settings_.coarse_after_s;
    if (!alignment.aligned() && (!overdue || mean.count < 10)) return;
    if (!alignment.aligned()) {
        // On the way: up is about where the mean force points, and the gyro's bias is unknown.
        const Eigen::Vector3d up = mean.specific_force_base_mps2.normalized();
        alignment.state.q_map_base =
            Eigen::Quaterniond(Eigen::AngleAxisd(T_map_base_.phi_rad, Eigen::Vector3d::UnitZ())) *
            inertial::upright(up);
        alignment.state.p_map_m = Eigen::Vector3d(T_map_base_.x_m, T_map_base_.y_m, 0) +
                                  alignment.state.q_map_base * place_.p_base_imu_m;
        alignment.state.v_map_mps.setZero();
        alignment.covariance.setZero();
        const double sigma[5] = {0.02, 1.5, 3 * M_PI / 180, 0.5 * M_PI / 180,
                                 settings_.alignment.sigma_accelerometer_bias_mps2};
        for (int k = 0; k < 15; ++k) alignment.covariance(k, k) = sigma[k / 3] * sigma[k / 3];
    } else {
        alignment.state.p_map_m += alignment.state.q_map_base * place_.p_base_imu_m;
    }
    alignment.state.stamp_ns = latest_->stamp_ns;
    filter_.start(alignment.state, alignment.covariance);
    aligned_ = true;
}

/// As the wheels say, or as if the vehicle went on as it did.
Prediction InertialNavigation::steady(StampNs stamp_ns, const std::optional<Pose2>& T_odom_base) const {
    Prediction p;
    p.stamp_ns = stamp_ns;
    p.duration_s = scan_ns_ ? seconds_between(*scan_ns_, stamp_ns) : 0;
    p.motion.T_before_now = T_before_now_;
    if (settings_.wheels && T_odom_base && T_odom_base_)
        p.motion.T_before_now = T_odom_base_->inverse() * *T_odom_base;
    p.motion.covariance.diagonal() << std::pow(settings_.sigma_steady_m, 2),
        std::pow(settings_.sigma_steady_m, 2), std::pow(settings_.sigma_steady_rad, 2);
    const Motion now = Motion{T_map_base_, covariance_} * p.motion;
    p.T_map_base = now.T_before_now;
    p.covariance = now.covariance;
    return p;
}

Prediction InertialNavigation::predict(StampNs stamp_ns, const std::optional<Pose2>& T_odom_base) {
    const bool was_aligned = aligned_;
    // Motion begins where the filter is, which is not quite where the scan was put: their difference would
    // count as motion at each scan.
    const Pose2 T_map_before = aligned_ ? inertial::base_pose(filter_.state(), place_).planar() : T_map_base_;
    propagate(stamp_ns);
    if (!aligned_) try_to_align();
    Prediction p = steady(stamp_ns, T_odom_base);
    scan_ns_ = stamp_ns;
    step_s_ = p.duration_s;
    if (!was_aligned) {
        if (T_odom_base) T_odom_base_ = T_odom_base;
        return p;
    }
    doubt_the_turn(
        filter_, settings_,
        wrap_to_pi(inertial::base_pose(filter_.state(), place_).planar().phi_rad - T_map_before.phi_rad));
    take_wheels(T_odom_base, p.duration_s);
    filter_.update(inertial::level_floor_measurement(filter_.state(), place_, settings_.floor));
    p.T_map_base = inertial::base_pose(filter_.state(), place_).planar();
    p.motion.T_before_now = T_map_before.inverse() * p.T_map_base;

    const auto& P = filter_.covariance();
    const auto measured =
        inertial::pose_measurement(filter_.state(), place_, p.T_map_base, Eigen::Matrix3d::Identity());
    // The filter's pose errs with the map that it was told by: so much may the next scan differ.
    p.covariance = measured.H * P * measured.H.transpose() + settings_.map.covariance();
    p.motion.covariance =
        turned(error_of_step(filter_, settings_, p.duration_s, p.motion.T_before_now.phi_rad),
               -T_map_before.phi_rad);
    return p;
}

void InertialNavigation::take_wheels(const std::optional<Pose2>& T_odom_base, double duration_s) {
    if (settings_.wheels && T_odom_base && T_odom_base_ && duration_s > 1e-3 && latest_) {
        const Twist2 twist = log_se2(T_odom_base_->inverse() * *T_odom_base) * (1 / duration_s);
        const auto& omega = latest_->omega_base_radps;
        constexpr double gate = 0.999;
        const auto forward = inertial::base_speed_measurement(filter_.state(), place_, omega, 0,
                                                              twist.forward_m, settings_.sigma_wheel_mps);
        if (!filter_.update(forward, gate).accepted()) ++refused_;
        const auto sideways = inertial::base_speed_measurement(filter_.state(), place_, omega, 1,
                                                               twist.left_m, settings_.sigma_side_mps);
        if (!filter_.update(sideways, gate).accepted()) ++refused_;
    }
    if (T_odom_base) T_odom_base_ = T_odom_base;
}

void InertialNavigation::update(const ForwardMatch& match) {
    // A motion that scans do not hold is not one to go on with: it would run away along a corridor.
    T_before_now_ =
        match.degeneracy.free_directions == 0 ? T_map_base_.inverse() * match.T_map_base : Pose2{};
    T_map_base_ = match.T_map_base;
    covariance_ = match.begins_map ? Eigen::Matrix3d::Zero().eval() : match.covariance;
    if (aligned_ && match.begins_map) begin_map(filter_);
    if (!aligned_ || !match.matched) return;
    const auto pose = without_the_map_noise(match, settings_.map.covariance(step_s_));
    filter_.update(inertial::pose_measurement(filter_.state(), place_, pose));
}

void InertialNavigation::move(const Pose2& T_new_old) {
    T_map_base_ = T_new_old * T_map_base_;
    covariance_ = turned(covariance_, T_new_old.phi_rad);
    if (!aligned_) return;
    move_filter(filter_, T_new_old);
}

InertialReverse::InertialReverse(const InertialNavigation& navigation, const MapFrames& map)
    : navigation_(navigation), map_(map) {}

void InertialReverse::start(std::uint32_t frame, const Pose2& T_map_base, const Eigen::Matrix3d& covariance) {
    filter_ = navigation_.filter();
    frame_ = frame;
    const Pose2 was = inertial::base_pose(filter_.state(), navigation_.place_).planar();
    move_filter(filter_, T_map_base * was.inverse());
    // The pose is the loop's. What forward knows of speed and attitude it has from the readings that are to
    // come again, so they count for little; the biases, which these do not tell in a moment, are kept.
    inertial::ErrorMatrix P = inertial::ErrorMatrix::Zero();
    constexpr double sigma_speed_mps = 0.1, sigma_tilt_rad = 0.5 * M_PI / 180;
    P.block<2, 2>(0, 0) = covariance.topLeftCorner<2, 2>();
    P(2, 2) = 1e-4;
    P.block<2, 1>(0, inertial::attitude_error + 2) = covariance.block<2, 1>(0, 2);
    P.block<1, 2>(inertial::attitude_error + 2, 0) = covariance.block<1, 2>(2, 0);
    for (int k = 0; k < 3; ++k)
        P(inertial::velocity_error + k, inertial::velocity_error + k) = sigma_speed_mps * sigma_speed_mps;
    for (int k = 0; k < 2; ++k)
        P(inertial::attitude_error + k, inertial::attitude_error + k) = sigma_tilt_rad * sigma_tilt_rad;
    P(inertial::attitude_error + 2, inertial::attitude_error + 2) = covariance(2, 2) + 1e-8;
    P.bottomRightCorner<6, 6>() = filter_.covariance().bottomRightCorner<6, 6>();
    filter_.start(filter_.state(), P);
    // The reading at the frame itself, then those before it.
    const auto& readings = navigation_.readings_;
    next_ = static_cast<std::size_t>(
        std::upper_bound(readings.begin(), readings.end(), map_.stamps_ns[frame],
                         [](StampNs t, const inertial::ImuSample& s) { return t < s.stamp_ns; }) -
        readings.begin());
    latest_ = reading_at(map_.stamps_ns[frame]);
}

/// Between the two readings around it; `next_` is the later one.
inertial::ImuSample InertialReverse::reading_at(StampNs stamp_ns) const {
    const auto& readings = navigation_.readings_;
    if (next_ == 0 || next_ == readings.size()) {
        inertial::ImuSample held = readings[next_ == 0 ? 0 : next_ - 1];
        held.stamp_ns = stamp_ns;
        return held;
    }
    return between(readings[next_ - 1], readings[next_], stamp_ns);
}

Motion InertialReverse::motion_back(std::uint32_t to) {
    const StampNs stamp_ns = map_.stamps_ns[to];
    const Pose2 T_map_after = inertial::base_pose(filter_.state(), navigation_.place_).planar();
    const double duration_s = seconds_between(stamp_ns, map_.stamps_ns[frame_]);
    step_s_ = duration_s;
    const auto& readings = navigation_.readings_;
    while (next_ > 0 && readings[next_ - 1].stamp_ns > stamp_ns) {
        if (readings[next_ - 1].stamp_ns < latest_.stamp_ns)
            filter_.predict_reverse(readings[next_ - 1], latest_), latest_ = readings[next_ - 1];
        --next_;
    }
    const inertial::ImuSample there = reading_at(stamp_ns);
    if (there.stamp_ns < latest_.stamp_ns) filter_.predict_reverse(there, latest_), latest_ = there;
    doubt_the_turn(filter_, navigation_.settings_,
                   wrap_to_pi(inertial::base_pose(filter_.state(), navigation_.place_).planar().phi_rad -
                              T_map_after.phi_rad));
    filter_.update(
        inertial::level_floor_measurement(filter_.state(), navigation_.place_, navigation_.settings_.floor));
    frame_ = to;
    const Pose2 T_map_there = inertial::base_pose(filter_.state(), navigation_.place_).planar();
    const Pose2 T_after_there = T_map_after.inverse() * T_map_there;
    return {T_after_there,
            turned(error_of_step(filter_, navigation_.settings_, duration_s, T_after_there.phi_rad),
                   -T_map_after.phi_rad)};
}

void InertialReverse::update(const ForwardMatch& match) {
    if (!match.matched) return;
    const auto pose = without_the_map_noise(match, navigation_.settings_.map.covariance(step_s_));
    filter_.update(inertial::pose_measurement(filter_.state(), navigation_.place_, pose));
}

}  // namespace loopline::grid_slam
