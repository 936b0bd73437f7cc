#include "lidar_mapping/sweep_mapping.h"

#include <algorithm>
#include <cmath>

#include "api/dense_algebra.h"
#include "inertial/pose_error.h"
#include "lidar_mapping/lasting_error.h"
#include "lidar_mapping/place_noise.h"

namespace loopline::lidar_mapping {
namespace {

/// A sweep is sought farther around if it agrees with the map so much less than those before.
constexpr double doubtful_part = 0.93, jerk_factor = 10;

/// Where the surroundings hold a sweep no better than this, much would fit.
constexpr double clear_m = 0.01;

/// While the speed at the start is sought, one of so many points of the second sweep is matched.
constexpr std::size_t search_every = 3;

/// Sweeps that go to the map wherever the vehicle is.
constexpr std::uint64_t first_sweeps = 5;

MotionState standing_state() {
    MotionState state;
    Vector12d sigma;
    sigma << Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(1e-4),
        Eigen::Vector3d::Constant(1e-2), Eigen::Vector3d::Constant(1e-3);
    state.covariance = sigma.cwiseAbs2().asDiagonal();
    return state;
}

/// Squared distance of the poses, of which 6 are expected by chance.
bool has_moved(const MotionState& from, const MotionState& to) {
    constexpr double contradiction = 50;
    const Vector12d moved = difference(to, from);
    const Matrix6d covariance = to.covariance.topLeftCorner<6, 6>();
    return squared_in_sigmas(moved.head<6>(), covariance) > contradiction;
}

}  // namespace

const Registration& SweepMapping::add(const lidar::SpinningScan& scan, const GivenMotion* given) {
    sampler_.sample(scan, settings_.sampling, settings_.map_voxel_m, points_);
    sampler_.thin_out(points_, settings_.match_voxel_m, matched_);
    const StampNs middle_ns = scan.stamp_ns + std::llround(1e9 * (scan.begin_s + scan.end_s) / 2);
    stands_ = stands_ && given == nullptr && standstill_.lasts(scan);
    const double duration_s = seconds_between(last_ns_, middle_ns);
    const Eigen::Vector3d before_m = last_.state.T_map_base.translation_m;
    const Matrix6d free_before = last_.by_prediction;
    if (sweeps_ == 0)
        begin(seconds_between(scan.stamp_ns, middle_ns));
    else if (given != nullptr && duration_s > 0)
        follow_given(duration_s, *given);
    else if (sweeps_ > 1 || speed_is_known_)
        follow(duration_s);
    else if (!stands_)
        follow_first(duration_s);
    if (sweeps_ == 1) first_ = {};
    carry_covariance(last_.state.T_map_base.translation_m - before_m, free_before);
    ++sweeps_;
    last_ns_ = middle_ns;
    if (sweeps_ <= first_sweeps || is_away_from_last_added()) {
        added_at_ = last_.state.T_map_base;
        add_to_map(points_, last_.state);
    }
    forget();
    return last_;
}

/// Sweeps from nearly the same place, whose poses differ by their errors, would make surfaces of these.
bool SweepMapping::is_away_from_last_added() const {
    const Pose3 since = added_at_.inverse() * last_.state.T_map_base;
    return since.translation_m.norm() > settings_.map_step_m ||
           inertial::log_so3(since.rotation).norm() > settings_.map_turn_rad;
}

void SweepMapping::carry_covariance(const Eigen::Vector3d& way_m, const Matrix6d& free_before) {
    if (sweeps_ == 0 || stands_) return;
    const Matrix6d F = inertial::carried_along(way_m);
    const bool sets_off = covariance_.isZero();
    Matrix6d carried = Matrix6d::Zero();
    if (!sets_off) carried = propagated(F, free_before);
    covariance_ = propagated(F, covariance_) + what_is_new(last_, carried) + of_coming_back(last_, carried) +
                  (sets_off ? last_.by_scan : what_lasts(last_));
}

/// A vehicle that stands is still looked at: whether its surroundings would hold it is reported, and where
/// they do, they show the first centimetre of its way.
void SweepMapping::follow(double duration_s) {
    const MotionState before = last_.state;
    last_ = register_sweep(map_, matched_, predict(before, duration_s, settings_.motion),
                           settings_.registration, workers_);
    if (last_.agreement() < doubtful_part * usual_agreement_ && last_.degeneracy.weakest_sigma_m < clear_m)
        search_wider(before, duration_s);
    usual_agreement_ += (last_.agreement() - usual_agreement_) / 10;
    stands_ = stands_ && !has_moved(before, last_.state);
    if (stands_) last_.state = before;
}

/// A jerk, or a gap in the log: large cubes draw the sweep in from afar, the others then find its place.
void SweepMapping::search_wider(const MotionState& before, double duration_s) {
    MotionNoise jerk = settings_.motion;
    jerk.sigma_acceleration_mps2 *= jerk_factor;
    jerk.sigma_turn_radps2 *= jerk_factor;
    const MotionState predicted = predict(before, duration_s, jerk);
    RegistrationSettings coarse = settings_.registration;
    coarse.smallest_size = map_.sizes() / 2;
    const Registration drawn_in = register_sweep(map_, matched_, predicted, coarse, workers_);
    const Registration found =
        register_sweep(map_, matched_, predicted, settings_.registration, workers_, &drawn_in.state);
    if (found.support > last_.support) last_ = found;
}

void SweepMapping::begin_at_speed(const Twist3& velocity, const Matrix6d& covariance) {
    speed_is_known_ = true;
    stands_ = false;
    last_.state.velocity = velocity;
    last_.state.covariance.bottomRightCorner<6, 6>() = covariance;
}

void SweepMapping::begin(double middle_s) {
    first_ = points_;
    first_middle_s_ = middle_s;
    if (!speed_is_known_) {
        last_.state = standing_state();
        return;
    }
    MotionState first = moving_first(last_.state.velocity);
    first.covariance.bottomRightCorner<6, 6>() = last_.state.covariance.bottomRightCorner<6, 6>();
    last_.state = first;
}

/// The map's origin is where the vehicle was at the stamp of the first sweep.
MotionState SweepMapping::moving_first(const Twist3& velocity) const {
    MotionState state = first_state(settings_.motion);
    state.velocity = velocity;
    state.T_map_base = exp_se3(velocity * first_middle_s_);
    return state;
}

/// The velocity of the first sweep is a guess: nothing is accelerated from there.
MotionState SweepMapping::second_after(const MotionState& first, double duration_s) const {
    MotionState second = predict(first, duration_s, settings_.motion);
    second.duration_s = 0;
    return second;
}

/// How fast the vehicle is at the start, nothing tells but the second sweep: speeds are tried, forward. At a
/// constant twist a thing that is seen at the same time of both sweeps lies exp(tau xi) apart in them as they
/// came: so for the search neither is undistorted, and the first one makes a map only once.
Twist3 SweepMapping::search_first_velocity(double duration_s) {
    RegistrationSettings rough = settings_.registration;
    rough.iterations = std::min(rough.iterations, 5);
    rough.few = 0;  // of every third point
    std::vector<SweepPoint> still = first_, few;
    for (SweepPoint& point : still) point.time_s = 0;
    for (std::size_t i = 0; i < matched_.size(); i += search_every) {
        few.push_back(matched_[i]);
        few.back().time_s = 0;
    }
    MotionState first = first_state(settings_.motion);
    map_.clear();
    add_to_map(still, first);
    const auto try_speed = [&](double speed_mps) {
        first.velocity = {{speed_mps, 0, 0}, {0, 0, 0}};
        return register_sweep(map_, few, second_after(first, duration_s), rough, workers_);
    };
    Registration best = try_speed(0);
    double speed_mps = 0;
    for (int worse = 0; worse < 2 && speed_mps < settings_.first_speed_max_mps;) {
        speed_mps += settings_.first_speed_step_mps;
        const Registration tried = try_speed(speed_mps);
        const bool better = tried.support > 1.1 * best.support;
        worse = better ? 0 : worse + 1;
        if (better) best = tried;
    }
    return log_se3(best.state.T_map_base) * (1 / duration_s);
}

/// The first sweep is put into the map as it was seen from the vehicle at the speed that fits best.
void SweepMapping::follow_first(double duration_s) {
    const auto follow_from = [&](const Twist3& velocity) {
        const MotionState first = moving_first(velocity);
        map_.clear();
        add_to_map(first_, first);
        last_ =
            register_sweep(map_, matched_, second_after(first, duration_s), settings_.registration, workers_);
    };
    follow_from(duration_s > 0 ? search_first_velocity(duration_s) : Twist3());
}

MotionState SweepMapping::carried(const GivenMotion& given, double duration_s) const {
    return predict(sweeps_ == 1 ? moving_first(given.velocity_before) : last_.state, given, duration_s,
                   settings_.motion);
}

void SweepMapping::follow_given(double duration_s, const GivenMotion& given) {
    const MotionState predicted = carried(given, duration_s);
    if (sweeps_ == 1) {
        map_.clear();
        add_to_map(first_, moving_first(given.velocity_before));
    }
    last_ = register_sweep(map_, matched_, predicted, settings_.registration, workers_);
}

void SweepMapping::add_to_map(const std::vector<SweepPoint>& points, const MotionState& state) {
    returns_.clear();
    map_.begin_sweep();
    const Eigen::Matrix3d R = state.T_map_base.rotation.toRotationMatrix();
    const Eigen::Matrix3f beams = R.cast<float>();
    const SweepMotion motion(state);
    const PlaceNoise noise(against_neighbours(state.covariance.topLeftCorner<6, 6>()),
                           settings_.map.sigma_range_m);
    for (const SweepPoint& point : points) {
        const Eigen::Vector3d arm_m = R * undistorted(point, motion);
        returns_.push_back({state.T_map_base.translation_m + arm_m,
                            noise.covariance_m2(arm_m.cast<float>(), beams * point.beam_base)});
    }
    workers_.run(map_.sizes(), [&](std::size_t size) { map_.add(size, returns_); });
}

void SweepMapping::forget() {
    const Eigen::Vector3d& now_m = last_.state.T_map_base.translation_m;
    if ((now_m - forgot_at_m_).norm() < settings_.forget_every_m) return;
    forgot_at_m_ = now_m;
    map_.keep_around(now_m);
}

}  // namespace loopline::lidar_mapping
