#include "grid_slam/grid_localisation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace loopline::grid_slam {
namespace {

Eigen::Matrix3d start_covariance(const LocalisationSettings& settings) {
    return Eigen::Vector3d(settings.sigma_start_m, settings.sigma_start_m, settings.sigma_start_rad)
        .cwiseAbs2()
        .asDiagonal();
}

}  // namespace

grid_map::RefinementSettings refinement_on(double map_cell_m, grid_map::RefinementSettings settings) {
    // A surface is anywhere in its cell.
    settings.sigma_m = std::hypot(settings.sigma_m, map_cell_m / std::sqrt(12.0));
    settings.reach_m = std::max(settings.reach_m, 2 * map_cell_m);
    return settings;
}

GridLocalisation::GridLocalisation(const LocalisationSettings& settings, const FrozenMap& map)
    : settings_(settings), on_map_(settings.forward), map_(map), search_(settings.start) {
    on_map_.refinement = refinement_on(map.cell_m(), settings.forward.refinement);
    settings_.start.refinement = on_map_.refinement;
    fitting_ = since_fitting_ = {settings.T_map_start, start_covariance(settings)};
    const double reach = settings.forward.window_sigmas;
    const bool within_reach = reach * settings.sigma_start_m <= settings.forward.max_window_m &&
                              reach * settings.sigma_start_rad <= settings.forward.max_window_rad;
    if (!settings.start_given)
        begin_search(true, {});
    else if (!within_reach)
        begin_search(false, since_fitting_);
}

GridSlamSettings GridLocalisation::local_settings() const {
    GridSlamSettings local;
    local.frame = settings_.frame;
    local.forward = settings_.forward;
    local.links.refinement = settings_.forward.refinement;
    local.links.visits = 0;
    local.loops.every_m = std::numeric_limits<double>::infinity();
    return local;
}

/// `guess`: where the vehicle may be now, with a covariance along the axes of the map.
void GridLocalisation::begin_search(bool whole_map, const Motion& guess) {
    local_ = std::make_unique<GridSlam>(local_settings());
    region_ = {whole_map, guess.T_before_now, guess.covariance};
    T_map_local_ = guess.T_before_now;
    covariance_at_first_ = guess.covariance;
    local_way_m_ = 0;
    earlier_looks_ += search_.looks();
    search_ = StartSearch(settings_.start);
    lost_.push_back({scans_, scans_, 0, false});
}

void GridLocalisation::keep(const Pose2& T_map_base, const Eigen::Matrix3d& covariance) {
    poses_.push_back(T_map_base);
    covariances_.push_back(covariance);
}

LocalisedScan GridLocalisation::add(const PlanarScan& scan, const Prediction& prediction,
                                    const grid_map::SweepMotion& sweep) {
    const double step_m = prediction.motion.T_before_now.translation().norm();
    way_m_ += step_m;
    LocalisedScan result;
    if (is_searching()) {
        local_way_m_ += step_m;
        result = search(scan, prediction, sweep);
    } else {
        grid_map::make_frame(scan, sweep, settings_.frame, frame_);
        result = follow(prediction);
        if (way_m_ - fitting_at_m_ > settings_.lost_after_m) become_lost(scan, prediction, sweep, result);
    }
    if (result.known && !known_from_) {
        known_from_ = scans_;
        known_after_m_ = way_m_;
    }
    keep(result.T_map_base, result.covariance);
    ++scans_;
    if (!lost_.empty() && !lost_.back().found && is_searching()) {
        lost_.back().end_scan = scans_;
        lost_.back().way_m += step_m;
    }
    return result;
}

LocalisedScan GridLocalisation::follow(const Prediction& prediction) {
    LocalisedScan result;
    Eigen::Matrix3d covariance = prediction.covariance;
    if (scans_ == 0) covariance += start_covariance(settings_);
    result.match =
        match_forward(map_.grid(), map_.surfaces(), frame_, prediction.T_map_base, covariance, on_map_);
    const ForwardMatch& match = result.match;
    (match.matched ? matched_ : unmatched_) += 1;
    degenerate_ += match.degeneracy.free_directions > 0 ? 1 : 0;
    result.known = true;
    result.T_map_base = match.T_map_base;
    result.covariance = match.covariance;
    if (match.matched && match.fit >= settings_.good_fit) {
        fitting_ = since_fitting_ = {match.T_map_base, match.covariance};
        fitting_at_m_ = way_m_;
        unfitting_.clear();
    } else {
        since_fitting_ = since_fitting_ * prediction.motion;
        unfitting_.push_back(prediction.motion);
    }
    return result;
}

/// From now on the place is searched for around where the motion since the last fitting scan leads.
void GridLocalisation::become_lost(const PlanarScan& scan, const Prediction& prediction,
                                   const grid_map::SweepMotion& sweep, LocalisedScan& result) {
    Motion by_motion = fitting_;
    for (std::size_t k = 0; k + 1 < unfitting_.size(); ++k) {
        by_motion = by_motion * unfitting_[k];
        const std::size_t scan_index = poses_.size() + 1 + k - unfitting_.size();
        poses_[scan_index] = by_motion.T_before_now;
        covariances_[scan_index] = by_motion.covariance;
    }
    begin_search(false, since_fitting_);
    const ScanPose first = local_->add(scan, prediction, sweep);
    result.T_new_old = prediction.T_map_base.inverse();  // navigation goes on in the frame of the local map
    result.match = first.match;
    result.T_map_base = since_fitting_.T_before_now;
    result.covariance = since_fitting_.covariance;
}

/// Mapping on its own errs by little beside what was uncertain when the search began.
Eigen::Matrix3d GridLocalisation::grown_since_search_began() const {
    constexpr double per_way = 0.02, rad_per_m = 0.2 * M_PI / 180;
    const Eigen::Matrix3d carried = carried_by(region_.T_map_base.translation() - T_map_local_.translation());
    const double grown_m = per_way * local_way_m_, grown_rad = rad_per_m * local_way_m_;
    Eigen::Matrix3d covariance = carried * covariance_at_first_ * carried.transpose();
    covariance.diagonal() += Eigen::Vector3d(grown_m, grown_m, grown_rad).cwiseAbs2();
    return covariance;
}

LocalisedScan GridLocalisation::search(const PlanarScan& scan, const Prediction& prediction,
                                       const grid_map::SweepMotion& sweep) {
    LocalisedScan result;
    if (const auto T_new_old = local_->advance()) result.T_new_old = T_new_old;
    const ScanPose local = local_->add(scan, prediction, sweep);
    result.match = local.match;
    result.known = !region_.whole_map;
    if (result.known) {
        region_.T_map_base = T_map_local_ * local.T_map_base;
        region_.covariance = grown_since_search_began();
        result.T_map_base = region_.T_map_base;
        result.covariance = region_.covariance;
    } else {
        result.T_map_base = local.T_map_base;
    }
    const MapFrames& frames = local_->map();
    const auto found = search_.look(map_, frames, local_way_m_, region_);
    if (!found) return result;

    const Pose2 T_frame_base = frames.poses[frames.last()].inverse() * local.T_map_base,
                T_map_base = found->T_map_base * T_frame_base;
    result.known = true;
    result.T_new_old = T_map_base * local.T_map_base.inverse();
    result.match = {};
    result.match.matched = true;
    result.match.fit = found->fit;
    result.match.T_map_base = T_map_base;
    result.match.covariance = found->covariance;
    result.match.information = found->information;
    result.T_map_base = T_map_base;
    result.covariance = found->covariance;
    lay_out_backwards(*found);
    fitting_ = since_fitting_ = {T_map_base, found->covariance};
    fitting_at_m_ = way_m_;
    unfitting_.clear();
    local_.reset();
    lost_.back().found = true;
    return result;
}

/// Poses of the scans since the search began, and of those before it that did not fit: backwards by the
/// motion, from where the vehicle was found; where they were known before, what both ways say together.
void GridLocalisation::lay_out_backwards(const StartFound& found) {
    const std::size_t searched = local_->scans() - 1;  // the scan at hand is not among the poses yet
    local_->finish();
    std::vector<Pose2> T_local_base;
    std::vector<Eigen::Matrix3d> local_covariances;
    local_->path(T_local_base, local_covariances);
    const MapFrames& frames = local_->map();
    const Pose2 T_map_local = found.T_map_base * frames.poses[frames.last()].inverse();

    // A chain that is known from its beginning is known from its end by what is left of it.
    PassResult back;
    for (std::size_t k = 0; k < searched; ++k) {
        const double left = 1 - static_cast<double>(k) / static_cast<double>(searched);
        const Pose2 T = T_map_local * T_local_base[k];
        const Eigen::Matrix3d carried = carried_by(T.translation() - found.T_map_base.translation());
        back.poses.push_back(T);
        back.covariances.push_back(carried * found.covariance * carried.transpose() +
                                   left * turned(local_covariances.back(), T_map_local.phi_rad));
    }
    Motion there;
    if (searched > 0) there = {back.poses.front(), back.covariances.front()};
    // The scan that the search began with is the last of those that did not fit.
    PassResult earlier;
    for (std::size_t k = unfitting_.size(); k-- > 1 && searched > 0;) {
        there = there * inverse(unfitting_[k]);
        earlier.poses.push_back(there.T_before_now);
        earlier.covariances.push_back(there.covariance);
    }
    back.poses.insert(back.poses.begin(), earlier.poses.rbegin(), earlier.poses.rend());
    back.covariances.insert(back.covariances.begin(), earlier.covariances.rbegin(),
                            earlier.covariances.rend());
    const std::size_t count = back.poses.size(), first = poses_.size() - count;
    if (!region_.whole_map) {
        PassResult before;
        before.poses.assign(poses_.begin() + static_cast<std::ptrdiff_t>(first), poses_.end());
        before.covariances.assign(covariances_.begin() + static_cast<std::ptrdiff_t>(first),
                                  covariances_.end());
        back = fuse(before, back, Weights::covariance);
    }
    std::copy(back.poses.begin(), back.poses.end(), poses_.begin() + static_cast<std::ptrdiff_t>(first));
    std::copy(back.covariances.begin(), back.covariances.end(),
              covariances_.begin() + static_cast<std::ptrdiff_t>(first));
}

}  // namespace loopline::grid_slam
