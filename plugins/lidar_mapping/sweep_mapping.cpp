#include "lidar_mapping/sweep_mapping.h"

#include <cmath>

#include "inertial/rotation_vector.h"

namespace loopline::lidar_mapping {

const Registration& SweepMapping::add(const lidar::SpinningScan& scan, const GivenMotion* given) {
    sampler_.sample(scan, settings_.sampling, settings_.map_voxel_m, points_);
    sampler_.thin_out(points_, settings_.match_voxel_m, matched_);
    const StampNs middle_ns = scan.stamp_ns + std::llround(1e9 * (scan.begin_s + scan.end_s) / 2);
    const double duration_s = seconds_between(last_ns_, middle_ns);
    const Eigen::Vector3d before_m = last_.state.T_map_base.translation_m;
    if (sweeps_ == 0)
        begin();
    else if (given != nullptr && duration_s > 0)
        follow_given(duration_s, *given);
    else if (sweeps_ == 1)
        follow_first(duration_s);
    else
        last_ = register_sweep(map_, matched_, predict(last_.state, duration_s, settings_.motion),
                               settings_.registration, workers_);
    carry_covariance(last_.state.T_map_base.translation_m - before_m);
    ++sweeps_;
    last_ns_ = middle_ns;
    add_to_map(points_, last_.state);
    forget();
    return last_;
}

void SweepMapping::carry_covariance(const Eigen::Vector3d& way_m) {
    if (sweeps_ == 0) return;
    Matrix6d F = Matrix6d::Identity();
    F.topRightCorner<3, 3>() = -inertial::cross_matrix(way_m);  // an error of the attitude turns the way
    covariance_ = F * covariance_ * F.transpose() + last_.state.covariance.topLeftCorner<6, 6>();
}

void SweepMapping::begin() {
    last_.state = first_state(settings_.motion);
    first_ = points_;
}

/// How fast the vehicle is at the start, nothing tells but the second sweep: speeds are tried, forward, and
/// the first sweep is put into the map as it was seen from the vehicle at the speed that fits best.
void SweepMapping::follow_first(double duration_s) {
    const MotionState first = last_.state;
    const auto try_from = [&](const Twist3& velocity) {
        MotionState state = first;
        state.velocity = velocity;
        map_.clear();
        add_to_map(first_, state);
        return register_sweep(map_, matched_, predict(state, duration_s, settings_.motion),
                              settings_.registration, workers_);
    };
    const auto velocity_of = [&](const Registration& found) {
        return log_se3(first.T_map_base.inverse() * found.state.T_map_base) * (1 / duration_s);
    };
    if (!(duration_s > 0)) {
        last_ = try_from({});
        first_.clear();
        return;
    }
    Registration best = try_from({});
    double speed_mps = 0;
    for (int worse = 0; worse < 2 && speed_mps < settings_.first_speed_max_mps;) {
        speed_mps += settings_.first_speed_step_mps;
        const Registration found = try_from({{speed_mps, 0, 0}, {0, 0, 0}});
        const bool better = found.support > 1.1 * best.support;
        worse = better ? 0 : worse + 1;
        if (better) best = found;
    }
    last_ = try_from(velocity_of(best));
    first_.clear();
    first_.shrink_to_fit();
}

/// As another odometry has it. It also tells the velocity of the first sweep.
void SweepMapping::follow_given(double duration_s, const GivenMotion& given) {
    if (sweeps_ == 1) {
        last_.state.velocity = given.velocity;
        map_.clear();
        add_to_map(first_, last_.state);
        first_.clear();
        first_.shrink_to_fit();
    }
    last_ = register_sweep(map_, matched_, predict(last_.state, given, duration_s, settings_.motion),
                           settings_.registration, workers_);
}

void SweepMapping::add_to_map(const std::vector<SweepPoint>& points, const MotionState& state) {
    points_map_m_.clear();
    for (const SweepPoint& point : points)
        points_map_m_.push_back(state.T_map_base * undistorted(point, state.velocity));
    workers_.run(map_.sizes(), [&](std::size_t size) {
        for (const Eigen::Vector3d& p_map_m : points_map_m_) map_.add(size, p_map_m);
    });
}

void SweepMapping::forget() {
    const Eigen::Vector3d& now_m = last_.state.T_map_base.translation_m;
    if ((now_m - forgot_at_m_).norm() < settings_.forget_every_m) return;
    forgot_at_m_ = now_m;
    map_.keep_around(now_m);
}

}  // namespace loopline::lidar_mapping
