#include "lidar_odometry/sweep_odometry.h"

#include <cmath>

#include "api/dense_algebra.h"
#include "inertial/pose_error.h"

namespace loopline::lidar_odometry {
namespace {

Matrix6d squares(double sigma_shift, double sigma_turn) {
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(sigma_shift), Eigen::Vector3d::Constant(sigma_turn);
    return sigma.cwiseAbs2().asDiagonal();
}

/// With one of so many of the points that are matched.
SweepFeatures one_of(SweepFeatures features, std::size_t every) {
    for (auto* list : {&features.edges, &features.planar}) {
        std::size_t count = 0;
        for (Feature& feature : *list)
            if (feature.matched != 0 && count++ % every != 0) feature.matched = 0;
    }
    return features;
}

/// All as if seen at one moment.
SweepFeatures still(SweepFeatures features) {
    for (auto* list : {&features.edges, &features.planar})
        for (Feature& feature : *list) feature.time_s = 0;
    return features;
}

}  // namespace

/// The velocity goes on, but for noise.
ExpectedMotion SweepOdometry::expected(double duration_s) const {
    const double s2 = duration_s * duration_s;
    ExpectedMotion motion;
    motion.duration_s = duration_s;
    motion.T_before_now = exp_se3(step_.velocity * duration_s);
    motion.covariance = s2 * velocity_covariance_ +
                        squares(settings_.sigma_acceleration_mps2 * s2, settings_.sigma_turn_radps2 * s2);
    return motion;
}

ExpectedMotion SweepOdometry::first_expected(const Twist3& velocity, double duration_s) const {
    ExpectedMotion motion;
    motion.duration_s = duration_s;
    motion.T_before_now = exp_se3(velocity * duration_s);
    motion.covariance =
        squares(settings_.sigma_first_speed_mps * duration_s, settings_.sigma_first_turn_radps * duration_s);
    return motion;
}

/// How fast the vehicle is at the start, nothing tells but the second sweep: speeds are tried. At a constant
/// twist a thing that is seen at the same time of both sweeps lies exp(tau xi) apart in them as they came: so
/// for the search neither is undistorted, and the first one is prepared only once.
Twist3 SweepOdometry::search_first_velocity(double duration_s) {
    MatchingSettings quick = settings_.matching;
    quick.rounds = 3;
    const SweepFeatures few = still(one_of(now_, 8));
    reference_.set(before_, {});
    const auto match_from = [&](double speed_mps) {
        return match_sweeps(reference_, few, first_expected({{speed_mps, 0, 0}, {0, 0, 0}}, duration_s),
                            quick, workers_);
    };
    MatchedMotion best = match_from(0);
    for (double speed_mps = settings_.first_speed_min_mps; speed_mps <= settings_.first_speed_max_mps;
         speed_mps += settings_.first_speed_step_mps) {
        const MatchedMotion found = match_from(speed_mps);
        if (found.support > best.support) best = found;
    }
    return log_se3(best.T_before_now) * (1 / duration_s);
}

MatchedMotion SweepOdometry::match_first(double duration_s) {
    const auto match_from = [&](const SweepFeatures& now, const Twist3& velocity) {
        reference_.set(before_, velocity);
        return match_sweeps(reference_, now, first_expected(velocity, duration_s), settings_.matching,
                            workers_);
    };
    const Twist3 nearly = search_first_velocity(duration_s);
    const Twist3 velocity = log_se3(match_from(one_of(now_, 3), nearly).T_before_now) * (1 / duration_s);
    // The map's origin is where the vehicle was at the stamp of the first sweep.
    T_map_middle_ = exp_se3(velocity * middle_s_);
    return match_from(now_, velocity);
}

bool SweepOdometry::add(const lidar::SpinningScan& scan) {
    const double middle_s = (scan.begin_s + scan.end_s) / 2;
    const StampNs middle_ns = scan.stamp_ns + std::llround(1e9 * middle_s);
    const double duration_s = seconds_between(middle_ns_, middle_ns);
    if (sweeps_ > 0 && !(duration_s > 0)) return false;
    finder_.find(scan, settings_.features, now_);
    middle_s_ = sweeps_ == 0 ? middle_s : middle_s_;
    if (sweeps_ == 1) {
        const MatchedMotion motion = match_first(duration_s);
        follow(motion, first_expected({}, duration_s));
    } else if (sweeps_ > 1) {
        reference_.set(before_, step_.velocity);
        const ExpectedMotion motion = expected(duration_s);
        follow(match_sweeps(reference_, now_, motion, settings_.matching, workers_), motion);
    }
    ++sweeps_;
    middle_ns_ = middle_ns;
    middle_s_ = middle_s;
    std::swap(before_, now_);
    step_.T_map_base = T_map_middle_ * exp_se3(step_.velocity * -middle_s);
    return true;
}

void SweepOdometry::follow(const MatchedMotion& motion, const ExpectedMotion& expected) {
    const Pose3 T_map_before = T_map_middle_;
    T_map_middle_ = T_map_before * motion.T_before_now;
    step_.motion = motion;
    const Twist3 before = step_.velocity * expected.duration_s, now = log_se3(motion.T_before_now);
    step_.velocity = now * (1 / expected.duration_s);

    // From (shift, turn) in front of T_before_now to those along the map's axes, about the vehicle.
    const Matrix6d to_map = inertial::turned_both(T_map_before.rotation) *
                            inertial::carried_along(motion.T_before_now.translation_m);
    Matrix6d covariance = motion.covariance;
    if (sweeps_ > 1) {
        // Where the velocity changes evenly by `change`, motion at a constant one is off by change / 8
        // midway.
        Vector6d change;
        change << now.shift_m - before.shift_m, now.turn_rad - before.turn_rad;
        covariance.diagonal() += (change / 8).cwiseAbs2();
    }
    const Matrix6d kept = motion.covariance * inverse_of(expected.covariance);
    carry_covariance(propagated(to_map, covariance), to_map * kept * inverse_of(to_map),
                     T_map_middle_.translation_m - T_map_before.translation_m, expected.duration_s);
}

/// Of the way and the velocity together. `kept`: what part of the expected motion's error is left in the
/// motion, along each direction: nothing in one that the scene holds, all in one that it leaves free.
void SweepOdometry::carry_covariance(const Matrix6d& motion, const Matrix6d& kept,
                                     const Eigen::Vector3d& way_m, double duration_s) {
    const Matrix6d carry = inertial::carried_along(way_m);
    const Matrix6d way_motion = carry * way_velocity_ * (duration_s * kept).transpose();
    step_.motion_covariance = motion;
    step_.covariance = propagated(carry, step_.covariance) + way_motion + way_motion.transpose() + motion;
    way_velocity_ = (way_motion + motion) / duration_s;
    velocity_covariance_ = motion / (duration_s * duration_s);
}

}  // namespace loopline::lidar_odometry
