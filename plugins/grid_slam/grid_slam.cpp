#include "grid_slam/grid_slam.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace loopline::grid_slam {
namespace {

grid_map::ScanGridSettings active_grid(const GridSlamSettings& settings) {
    grid_map::ScanGridSettings grid;
    grid.cell_m = settings.cell_m;
    grid.free_space = false;
    return grid;
}

/// A covariance of (x, y, phi) along other axes.
Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, double phi_rad) {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    const double c = std::cos(phi_rad), s = std::sin(phi_rad);
    turn.topLeftCorner<2, 2>() << c, -s, s, c;
    return turn * covariance * turn.transpose();
}

}  // namespace

GridSlam::GridSlam(const GridSlamSettings& settings)
    : settings_(settings), active_(active_grid(settings), settings.active), linker_(settings.links), loops_(settings.loops) {}

ScanPose GridSlam::add(const PlanarScan& scan, const Motion& motion) {
    grid_map::make_frame(scan, settings_.frame, frame_);
    ScanPose result;
    if (places_.empty()) {
        ForwardMatch first;
        first.matched = true;
        add_frame(first);
        places_.push_back({0, Pose2{}, Eigen::Matrix3d::Zero()});
        result.matched = true;
        result.fit = 1;
        return result;
    }
    result.corrected = advance_correction();
    const Place& before = places_.back();
    const Pose2 T_map_before = map_.poses[before.frame] * before.T_frame_base;
    way_m_ += motion.T_before_now.translation().norm();
    since_frame_ = since_frame_ * motion;

    // S2: forward matching, from where the motion leads.
    const ForwardMatch match = match_forward(active_.grid(), frame_, T_map_before * motion.T_before_now,
                                             turned(motion.covariance, T_map_before.phi_rad), settings_.forward);
    unmatched_ += match.matched ? 0 : 1;
    degenerate_ += match.degeneracy.free_directions > 0 ? 1 : 0;
    settle_on_frame(match);

    const Place& now = places_.back();
    result.T_map_base = map_.poses[now.frame] * now.T_frame_base;
    result.covariance = match.covariance;
    result.fit = match.fit;
    result.matched = match.matched;
    return result;
}

/// The scan rides on the frame it rode on before, or on another one that is nearer, or becomes a frame itself.
void GridSlam::settle_on_frame(const ForwardMatch& match) {
    const auto away = [&](std::uint32_t frame) { return map_.poses[frame].inverse() * match.T_map_base; };
    const auto is_near = [&](const Pose2& T) {
        return T.translation().norm() < settings_.frame_way_m && std::abs(T.phi_rad) < settings_.frame_turn_rad;
    };
    const auto ride_on = [&](std::uint32_t frame) {
        places_.push_back({frame, away(frame), turned(match.covariance, -map_.poses[frame].phi_rad)});
    };
    const std::uint32_t before = places_.back().frame;
    const bool map_is_right = match.matched && match.fit >= settings_.new_fit;
    if (is_near(away(before))) return ride_on(before);
    if (map_is_right)
        if (const auto other = near_frame(match.T_map_base)) {
            ride_on(*other);
            since_frame_ = {places_.back().T_frame_base, places_.back().covariance};
            return;
        }
    add_frame(match);
    ride_on(map_.last());
}

std::optional<std::uint32_t> GridSlam::near_frame(const Pose2& T_map_base) const {
    std::optional<std::uint32_t> nearest;
    double nearest_away = 1;
    for (const std::uint32_t frame : active_.active()) {
        const double way = (map_.poses[frame].translation() - T_map_base.translation()).norm() / settings_.frame_way_m;
        if (way >= nearest_away) continue;
        const double turn = std::abs(wrap_to_pi(map_.poses[frame].phi_rad - T_map_base.phi_rad)) / settings_.frame_turn_rad;
        if (std::max(way, turn) >= nearest_away) continue;
        nearest_away = std::max(way, turn);
        nearest = frame;
    }
    return nearest;
}

void GridSlam::add_frame(const ForwardMatch& match) {
    const bool first = map_.size() == 0;
    const std::uint32_t rode_on = first ? 0 : places_.back().frame;
    const std::uint32_t frame = map_.add(frame_, match.T_map_base, way_m_, places_.size());
    neighbourhood_.resize(map_.size());
    active_.add(map_, frame);
    if (first) return;

    Constraint moved;
    moved.from = rode_on;
    moved.to = frame;
    moved.T_from_to = since_frame_.T_before_now;
    moved.information = since_frame_.covariance.inverse();
    add_constraint(moved);
    since_frame_ = {};
    for (const Constraint& link : linker_.link(map_, active_, frame)) add_constraint(link);

    if (way_m_ - chosen_at_m_ >= settings_.choose_every_m) {
        chosen_at_m_ = way_m_;
        active_.choose(map_, neighbourhood_, frame);
    }
    if (correction_) return;
    // S3 and S4: is this an old place?
    const auto loop = loops_.look(map_, active_, neighbourhood_);
    if (loop.empty()) return;
    for (const Constraint& constraint : loop) add_constraint(constraint);
    loop_frame_ = frame;
    if (is_worth_correcting(loop.back())) {
        relink_after_ = true;
        begin_correction();
    } else {
        active_.choose(map_, neighbourhood_, frame);
        relink(frame);
    }
}

bool GridSlam::is_worth_correcting(const Constraint& constraint) const {
    const Eigen::Vector3d off = residual(constraint, map_.poses[constraint.from], map_.poses[constraint.to]);
    return off.head<2>().norm() > settings_.worth_m || std::abs(off.z()) > settings_.worth_rad;
}

void GridSlam::add_constraint(const Constraint& constraint) {
    constraints_.push_back(constraint);
    neighbourhood_.add(constraint, map_.poses[constraint.from]);
}

void GridSlam::begin_correction() {
    correction_.emplace(map_.poses, constraints_, settings_.online_graph);
    correction_frames_ = map_.size();
}

/// A part of the work of each correction goes with each scan, so that none has to wait for all of it.
bool GridSlam::advance_correction() {
    if (!correction_ || correction_->iterate()) return false;
    apply_correction();
    return true;
}

/// S7: all frames at their corrected poses; those taken since move with the last one.
void GridSlam::apply_correction() {
    if (correction_->good()) {
        const auto& corrected = correction_->poses();
        const std::size_t last = correction_frames_ - 1;
        const Pose2 T_new_old = corrected[last] * map_.poses[last].inverse();
        for (std::size_t k = correction_frames_; k < map_.size(); ++k) map_.poses[k] = T_new_old * map_.poses[k];
        std::copy(corrected.begin(), corrected.end(), map_.poses.begin());
        rebuild_neighbourhood();
        active_.choose(map_, neighbourhood_, map_.last());
        loops_.forget_pending();
        ++corrections_;
    }
    correction_.reset();
    if (!relink_after_) return;
    relink_after_ = false;
    const std::size_t before = constraints_.size();
    relink(loop_frame_);
    const bool again = std::any_of(constraints_.begin() + static_cast<std::ptrdiff_t>(before), constraints_.end(),
                                   [this](const Constraint& c) { return is_worth_correcting(c); });
    if (again) begin_correction();
}

void GridSlam::relink(std::uint32_t from_frame) {
    for (std::uint32_t frame = map_.last(); frame > 0 && map_.path_m[from_frame] - map_.path_m[frame] < settings_.relink_m; --frame)
        for (const Constraint& link : linker_.link(map_, active_, frame)) add_constraint(link);
}

void GridSlam::rebuild_neighbourhood() {
    neighbourhood_.clear();
    neighbourhood_.resize(map_.size());
    for (const Constraint& constraint : constraints_) neighbourhood_.add(constraint, map_.poses[constraint.from]);
}

void GridSlam::finish() {
    while (correction_) advance_correction();
    if (map_.size() < 2) {
        frame_covariances_.assign(map_.size(), Eigen::Matrix3d::Zero());
        return;
    }
    GraphOptimiser final_fit(map_.poses, constraints_, settings_.graph);
    while (final_fit.iterate()) {
    }
    if (final_fit.good()) map_.poses = final_fit.poses();
    frame_covariances_ = final_fit.covariances();
    frame_covariances_.resize(map_.size(), Eigen::Matrix3d::Zero());
}

void GridSlam::path(std::vector<Pose2>& poses, std::vector<Eigen::Matrix3d>& covariances) const {
    poses.clear();
    covariances.clear();
    poses.reserve(places_.size());
    covariances.reserve(places_.size());
    for (const Place& place : places_) {
        const Pose2& T_map_frame = map_.poses[place.frame];
        const Pose2 T_map_base = T_map_frame * place.T_frame_base;
        Eigen::Matrix3d carried = Eigen::Matrix3d::Identity();
        carried(0, 2) = -(T_map_base.y_m - T_map_frame.y_m);
        carried(1, 2) = T_map_base.x_m - T_map_frame.x_m;
        Eigen::Matrix3d covariance = turned(place.covariance, T_map_frame.phi_rad);
        if (place.frame < frame_covariances_.size()) covariance += carried * frame_covariances_[place.frame] * carried.transpose();
        poses.push_back(T_map_base);
        covariances.push_back(covariance);
    }
}

}  // namespace loopline::grid_slam
