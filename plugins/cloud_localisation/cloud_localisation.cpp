#include "cloud_localisation/cloud_localisation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "cloud_localisation/sweep_from_above.h"
#include "inertial/pose_error.h"

namespace loopline::cloud_localisation {
namespace {

using namespace lidar_mapping;

/// What a jerk, or a gap in the log, may be more than the motion's noise.
constexpr double jerk_factor = 10;
/// A map of its own errs by what it claims, and by so much of the way.
constexpr double error_per_way = 0.01, error_rad_per_m = 0.01 * M_PI / 180;
/// Two looks differ by no more.
constexpr double agree_per_way = 0.02;
constexpr std::size_t most_sightings = 20, most_fixes = 100;
/// The place counts as contradicted by fixes that are farther from the path than this, so many in a row.
constexpr double off_sigmas = 5;
constexpr int off_fixes = 3;
/// What is higher above the lowest point that the map has there, stands on the ground.
constexpr double above_ground_m = 0.5;
constexpr std::size_t fewest_standing = 30;  // returns; of fewer nothing can be told

}  // namespace

CloudLocalisation::CloudLocalisation(const LocalisationSettings& settings, const FrozenCloud& map,
                                     int threads, MapUncertainty uncertainty)
    : settings_(settings),
      map_(map),
      uncertainty_(std::move(uncertainty)),
      registration_(settings.sweeps.registration),
      workers_(threads),
      threads_(threads) {
    registration_.few = 0;  // many sweeps have made the map, and none of these
    settings_.start.registration = registration_;
    std::optional<Guess> guess;
    if (settings.T_map_start)
        guess = Guess{*settings.T_map_start, settings.sigma_start_m, settings.sigma_start_m,
                      settings.sigma_start_rad};
    begin_search(guess);
}

void CloudLocalisation::begin_search(const std::optional<Guess>& guess) {
    local_ = std::make_unique<SweepMapping>(settings_.sweeps, threads_);
    local_sweeps_ = 0;
    local_way_m_ = 0;
    guess_ = guess;
    sightings_.clear();
    way_.clear();
    looked_ns_.reset();
    off_in_a_row_ = 0;
}

void CloudLocalisation::take_fix(const FixInMap& fix) {
    fixes_.push_back(fix);
    if (fixes_.size() > most_fixes) fixes_.pop_front();
}

LocalisedSweep CloudLocalisation::add(const lidar::SpinningScan& scan, const GivenMotion* given) {
    sampler_.sample(scan, settings_.sweeps.sampling, settings_.sweeps.map_voxel_m, points_);
    sampler_.thin_out(points_, settings_.sweeps.match_voxel_m, matched_);
    const double middle_s = (scan.begin_s + scan.end_s) / 2;
    const StampNs middle_ns = scan.stamp_ns + std::llround(1e9 * middle_s);
    const double duration_s = latest_ns_ ? std::max(0.0, seconds_between(*latest_ns_, middle_ns)) : 0;
    ++counts_.sweeps;
    LocalisedSweep result;
    std::optional<PoseWithCovariance> lost_at;
    if (!is_searching() && !follow(given, duration_s, middle_ns)) {
        put(state_, middle_s, result);
        lost_at = {result.T_map_base, result.covariance};
        lose(middle_s);
    }
    if (is_searching())
        result = search(scan, given, middle_ns);
    else
        put(state_, middle_s, result);
    result.lost_at = lost_at;
    latest_ns_ = middle_ns;
    return result;
}

// ---- where the place is known ----

/// False if the place is known no longer.
bool CloudLocalisation::follow(const GivenMotion* given, double duration_s, StampNs middle_ns) {
    const MotionState before = state_;
    const MotionState predicted = given != nullptr
                                      ? predict(before, *given, duration_s, settings_.sweeps.motion)
                                      : predict(before, duration_s, settings_.sweeps.motion);
    Registration found = register_sweep(map_.surfaces(), matched_, predicted, registration_, workers_);
    double fit = fit_of(found);
    if (fit < settings_.good_fit) {
        MotionNoise jerk = settings_.sweeps.motion;
        jerk.sigma_acceleration_mps2 *= jerk_factor;
        jerk.sigma_turn_radps2 *= jerk_factor;
        const Registration wider = registered(given != nullptr ? predict(before, *given, duration_s, jerk)
                                                               : predict(before, duration_s, jerk));
        if (const double fit_of_wider = fit_of(wider); fit_of_wider > fit) {
            found = wider;
            fit = fit_of_wider;
        }
    }
    if (fit >= settings_.good_fit) {
        state_ = found.state;
        unfitting_s_ = 0;
        ++counts_.matched;
        sum_of_fits_ += fit;
    } else {
        state_ = predicted;
        unfitting_s_ += duration_s;
        ++counts_.unmatched;
    }
    counts_.degenerate += found.degeneracy.free_directions > 0 ? 1 : 0;
    if (unfitting_s_ > settings_.lost_after_s || !is_certain()) return false;
    remember({middle_ns, state_.T_map_base, state_.velocity});
    heed_fixes(middle_ns);
    ask_for_second_opinion(middle_ns);
    return true;
}

/// Large cubes draw the sweep in from afar, all of them then find its place.
Registration CloudLocalisation::registered(const MotionState& predicted) {
    RegistrationSettings coarse = registration_;
    coarse.smallest_size = map_.surfaces().sizes() / 2;
    const Registration drawn_in = register_sweep(map_.surfaces(), matched_, predicted, coarse, workers_);
    return register_sweep(map_.surfaces(), matched_, predicted, registration_, workers_, &drawn_in.state);
}

/// Beyond the map nothing is known of the ground, and nothing fits. Where next to nothing stands, as in a
/// field, all returns count that lie on surfaces.
double CloudLocalisation::fit_of(const Registration& found) const {
    const SweepMotion motion(found.state);
    std::size_t standing = 0, near = 0;
    for (const SweepPoint& point : matched_) {
        const Eigen::Vector3d p_map_m = found.state.T_map_base * undistorted(point, motion);
        const auto* column = map_.columns().find(p_map_m.x(), p_map_m.y());
        if (column != nullptr && p_map_m.z() - static_cast<double>(column->low_m) < above_ground_m) continue;
        ++standing;
        near += map_.surfaces().has_return_near(p_map_m) ? 1 : 0;
    }
    if (standing >= fewest_standing) return static_cast<double>(near) / static_cast<double>(standing);
    return matched_.empty() ? 0 : found.support / static_cast<double>(matched_.size());
}

bool CloudLocalisation::is_certain() const {
    const Eigen::Matrix3d covariance = state_.covariance.topLeftCorner<3, 3>();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
    return eigen.eigenvalues()[2] < settings_.max_sigma_m * settings_.max_sigma_m;
}

void CloudLocalisation::put(const MotionState& in_middle, double middle_s, LocalisedSweep& result) const {
    const MotionState at_stamp = predict(in_middle, -middle_s, MotionNoise{0, 0, 0, 0});
    result.known = true;
    result.T_map_base = lidar_mapping::pose_near(in_middle, -middle_s);
    result.covariance =
        at_stamp.covariance.topLeftCorner<6, 6>() + covariance_of_map(result.T_map_base.translation_m);
}

Matrix6d CloudLocalisation::covariance_of_map(const Eigen::Vector3d& p_map_m) const {
    Matrix6d covariance = uncertainty_.at(p_map_m);
    covariance.diagonal().head<3>().array() += settings_.sigma_map_m * settings_.sigma_map_m;
    covariance.diagonal().tail<3>().array() += settings_.sigma_map_rad * settings_.sigma_map_rad;
    return covariance;
}

// ---- where it is searched for ----

/// How fast the vehicle is, is still known.
void CloudLocalisation::lose(double middle_s) {
    ++counts_.lost;
    begin_search(guess_by_motion(middle_s));
    const Matrix6d to_base = inertial::turned_both(state_.T_map_base.rotation.conjugate());
    local_->begin_at_speed(state_.velocity, propagated(to_base, state_.covariance.bottomRightCorner<6, 6>()));
}

/// The vehicle's own frame at the stamp of the sweep at hand is that of the search's map.
CloudLocalisation::Guess CloudLocalisation::guess_by_motion(double middle_s) const {
    const MotionState at_stamp = predict(state_, -middle_s, MotionNoise{0, 0, 0, 0});
    const auto variance = [&](Eigen::Index a, Eigen::Index b) {
        return std::max(at_stamp.covariance(a, a), at_stamp.covariance(b, b));
    };
    return {lidar_mapping::pose_near(state_, -middle_s), std::sqrt(variance(0, 1)), std::sqrt(variance(2, 2)),
            std::sqrt(variance(5, 5))};
}

LocalisedSweep CloudLocalisation::search(const lidar::SpinningScan& scan, const GivenMotion* given,
                                         StampNs middle_ns) {
    const double middle_s = seconds_between(scan.stamp_ns, middle_ns);
    LocalisedSweep result;
    result.begins_search = local_sweeps_ == 0;
    ++counts_.searched;
    const Pose3 before = local_->latest().state.T_map_base;
    const MotionState own = local_->add(scan, given).state;
    local_way_m_ += (before.inverse() * own.T_map_base).translation_m.norm();
    // The first sweep's motion is known from the second one on.
    if (++local_sweeps_ == 2) way_.clear();
    const OnTheWay now{middle_ns, own.T_map_base, own.velocity};
    remember(now);
    heed_fixes(middle_ns);

    result.T_local_base = lidar_mapping::pose_near(own, -middle_s);
    result.local_covariance = local_->covariance();
    result.T_map_base = guess_ ? guess_->T_map_local * result.T_local_base : result.T_local_base;
    if (local_sweeps_ < 2 || !look_is_due(middle_ns) || !look(now)) return result;

    const Sighting sighting{own.T_map_base, look_.state.T_map_base};
    const bool twice = agrees(sighting);
    sightings_.push_back(sighting);
    if (sightings_.size() > most_sightings) sightings_.pop_front();
    if (!twice) {
        look_.reason = "no second look has agreed";
        return result;
    }
    ++counts_.starts;
    state_ = look_.state;
    unfitting_s_ = 0;
    off_in_a_row_ = 0;
    result.T_map_local = state_.T_map_base * own.T_map_base.inverse();
    for (OnTheWay& then : way_) then.T_frame_base = *result.T_map_local * then.T_frame_base;
    put(state_, middle_s, result);
    local_.reset();
    return result;
}

bool CloudLocalisation::look_is_due(StampNs middle_ns) const {
    return !looked_ns_ || seconds_between(*looked_ns_, middle_ns) >= settings_.search_every_s;
}

/// Around where the latest fix has it, and around where motion has brought the vehicle, by turns.
bool CloudLocalisation::look(const OnTheWay& now) {
    auto region = region_by_fix(now);
    const auto by_motion = region_by_guess(now);
    if (by_motion && (!region || counts_.looks % 2 == 1)) region = by_motion;
    if (!region) {
        look_ = {};
        look_.reason = "no usable fix has come";
        return false;
    }
    looked_ns_ = now.middle_ns;
    ++counts_.looks;
    look_ = look_for_start(map_, points_, matched_, now.velocity, *region, settings_.start, workers_);
    return look_.found;
}

bool CloudLocalisation::agrees(const Sighting& now) const {
    return std::any_of(sightings_.begin(), sightings_.end(), [&](const Sighting& earlier) {
        const Pose3 by_map = earlier.T_map_base.inverse() * now.T_map_base,
                    by_motion = earlier.T_local_base.inverse() * now.T_local_base,
                    off = by_motion.inverse() * by_map;
        return off.translation_m.norm() <
                   settings_.agree_m + agree_per_way * by_motion.translation_m.norm() &&
               off.rotation.angularDistance(Eigen::Quaterniond::Identity()) < settings_.agree_rad;
    });
}

std::optional<StartRegion> CloudLocalisation::region_by_guess(const OnTheWay& now) const {
    if (!guess_) return std::nullopt;
    const Pose3 T_map_base = guess_->T_map_local * now.T_frame_base;
    const Matrix6d& of_motion = local_->covariance();
    const double turned_m = guess_->sigma_yaw_rad * now.T_frame_base.translation_m.norm(),
                 grown_m = error_per_way * local_way_m_,
                 moved_m = std::sqrt(std::max(of_motion(0, 0), of_motion(1, 1)));
    StartRegion region;
    region.p_map_m = T_map_base.translation_m;
    region.sigma_m = std::hypot(guess_->sigma_m, turned_m, std::hypot(grown_m, moved_m));
    region.sigma_z_m = std::hypot(guess_->sigma_z_m, grown_m, std::sqrt(of_motion(2, 2)));
    region.yaw_rad = T_map_base.yaw_rad();
    region.sigma_yaw_rad =
        std::hypot(guess_->sigma_yaw_rad, error_rad_per_m * local_way_m_, std::sqrt(of_motion(5, 5)));
    return region;
}

std::optional<StartRegion> CloudLocalisation::region_by_fix(const OnTheWay& now) const {
    if (!latest_fix_ || seconds_between(latest_fix_->stamp_ns, now.middle_ns) > settings_.fix_age_s)
        return std::nullopt;
    const auto then = T_frame_base_at(latest_fix_->stamp_ns);
    if (!then) return std::nullopt;
    StartRegion region;
    region.p_map_m = latest_fix_->p_map_m;
    region.p_base_m = now.T_frame_base.inverse() * (*then * latest_fix_->p_base_antenna_m);
    region.sigma_m = latest_fix_->sigma_m;
    if (latest_fix_->has_height) region.sigma_z_m = latest_fix_->sigma_z_m;
    return region;
}

// ---- fixes ----

void CloudLocalisation::remember(const OnTheWay& now) {
    way_.push_back(now);
    while (seconds_between(way_.front().middle_ns, now.middle_ns) > settings_.fix_age_s + 1) way_.pop_front();
}

/// By the sweep nearest to that time.
std::optional<Pose3> CloudLocalisation::T_frame_base_at(StampNs stamp_ns) const {
    const OnTheWay* nearest = nullptr;
    const auto off_s = [&](const OnTheWay& pose) {
        return std::abs(seconds_between(pose.middle_ns, stamp_ns));
    };
    for (const OnTheWay& pose : way_)
        if (nearest == nullptr || off_s(pose) < off_s(*nearest)) nearest = &pose;
    if (nearest == nullptr || off_s(*nearest) > settings_.fix_age_s) return std::nullopt;
    return nearest->T_frame_base * exp_se3(nearest->velocity * seconds_between(nearest->middle_ns, stamp_ns));
}

/// Those that are not later than the sweep at hand.
void CloudLocalisation::heed_fixes(StampNs middle_ns) {
    for (; !fixes_.empty() && fixes_.front().stamp_ns <= middle_ns; fixes_.pop_front()) {
        latest_fix_ = fixes_.front();
        if (!is_searching()) compare_with(fixes_.front());
    }
}

void CloudLocalisation::compare_with(const FixInMap& fix) {
    const auto T_map_base = T_frame_base_at(fix.stamp_ns);
    if (!T_map_base) return;
    const Eigen::Vector2d off_m = (fix.p_map_m - *T_map_base * fix.p_base_antenna_m).head<2>();
    const Matrix6d covariance =
        state_.covariance.topLeftCorner<6, 6>() + covariance_of_map(T_map_base->translation_m);
    const double sigma_m = std::hypot(fix.sigma_m, std::sqrt(std::max(covariance(0, 0), covariance(1, 1))));
    const bool is_off = off_m.norm() > off_sigmas * sigma_m;
    counts_.fixes_off += is_off ? 1 : 0;
    if (is_off && off_in_a_row_ == 0) off_since_ns_ = fix.stamp_ns;
    off_in_a_row_ = is_off ? off_in_a_row_ + 1 : 0;
}

/// Fixes that go on contradicting the path may be wrong, or the path is: the sweep decides. It is moved to
/// where the fixes have it if it fits there, and not clearly worse; where the two places are alike, the fixes
/// tell which.
void CloudLocalisation::ask_for_second_opinion(StampNs middle_ns) {
    if (off_in_a_row_ < off_fixes || !look_is_due(middle_ns) ||
        seconds_between(off_since_ns_, middle_ns) < settings_.lost_after_s)
        return;
    const auto region = region_by_fix({middle_ns, state_.T_map_base, state_.velocity});
    if (!region) return;
    looked_ns_ = middle_ns;
    ++counts_.looks;
    const StartLook there =
        look_for_start(map_, points_, matched_, state_.velocity, *region, settings_.start, workers_);
    if (!there.found) return;
    const auto seen = seen_from_above(points_, state_.velocity, settings_.start.range_m);
    if (settings_.start.rival * fit_in_map(map_, seen.standing, state_) > there.fit) return;
    ++counts_.moved_by_fixes;
    state_ = there.state;
    way_.clear();
    off_in_a_row_ = 0;
    remember({middle_ns, state_.T_map_base, state_.velocity});
}

}  // namespace loopline::cloud_localisation
