#include "grid_slam/grid_slam.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "grid_slam/wheel_navigation.h"

namespace loopline::grid_slam {
namespace {

const char* const by_the_ini = "refused by the .ini";
/// Frames no farther apart than so many times frame_way_m and frame_turn_rad are of one place.
constexpr double known_around = 3;

grid_map::ScanGridSettings active_grid(const GridSlamSettings& settings) {
    grid_map::ScanGridSettings grid;
    grid.cell_m = settings.cell_m;
    grid.free_space = false;
    return grid;
}

}  // namespace

GridSlam::GridSlam(const GridSlamSettings& settings)
    : settings_(settings),
      active_(active_grid(settings), settings.active),
      linker_(settings.links),
      loops_(settings.loops),
      decisions_(settings.decisions) {}

ScanPose GridSlam::add(const PlanarScan& scan, const Prediction& prediction,
                       const grid_map::SweepMotion& sweep) {
    grid_map::make_frame(scan, sweep, settings_.frame, frame_);
    stamp_ns_ = prediction.stamp_ns;
    ScanPose result;
    if (places_.empty()) {
        result.match.matched = true;
        result.match.fit = 1;
        add_frame(result.match);
        ride(0, Pose2{}, Eigen::Matrix3d::Zero());
        decisions_.take_scan(stamp_ns_, 0);
        return result;
    }
    way_m_ += prediction.motion.T_before_now.translation().norm();
    since_frame_ = since_frame_ * prediction.motion;
    since_last_frame_ = since_last_frame_ * prediction.motion;

    // S2: forward matching, from where the motion leads.
    result.match = match_forward(active_.grid(), frame_, prediction.T_map_base, prediction.covariance,
                                 settings_.forward);
    unmatched_ += result.match.matched ? 0 : 1;
    degenerate_ += result.match.degeneracy.free_directions > 0 ? 1 : 0;
    if (result.match.motion_was_wrong) trust_motion_less(prediction.T_map_base, result.match.T_map_base);
    const std::uint32_t frames = map_.size();
    settle_on_frame(result.match);
    result.match.begins_map = !result.match.matched && map_.size() > frames &&
                              static_cast<int>(frame_.points.size()) >= settings_.forward.min_returns;
    decisions_.take_scan(stamp_ns_, rides_on());
    result.T_map_base = map_.poses[rides_on()] * latest_.T_frame_base;
    return result;
}

void GridSlam::ride(std::uint32_t frame, const Pose2& T_frame_base, const Eigen::Matrix3d& covariance) {
    latest_.frame = frame;
    latest_.T_frame_base = T_frame_base;
    Eigen::Map<Eigen::Matrix3d>{latest_.covariance} = covariance;
    places_.push_back(latest_);
}

/// The motion erred by what the scan was found off, whatever its noise may be.
void GridSlam::trust_motion_less(const Pose2& T_map_predicted, const Pose2& T_map_base) {
    ++motions_refused_;
    const Eigen::Vector3d off(T_map_base.x_m - T_map_predicted.x_m, T_map_base.y_m - T_map_predicted.y_m,
                              wrap_to_pi(T_map_base.phi_rad - T_map_predicted.phi_rad));
    const Eigen::Matrix3d squared = off * off.transpose();
    since_frame_.covariance += turned(squared, -map_.poses[rides_on()].phi_rad);
    since_last_frame_.covariance += turned(squared, -map_.poses.back().phi_rad);
}

/// The scan rides on the frame it rode on before, or on another one that is nearer, or becomes a frame
/// itself.
void GridSlam::settle_on_frame(const ForwardMatch& match) {
    const auto away = [&](std::uint32_t frame) { return map_.poses[frame].inverse() * match.T_map_base; };
    const auto is_near = [&](const Pose2& T) {
        return T.translation().norm() < settings_.frame_way_m &&
               std::abs(T.phi_rad) < settings_.frame_turn_rad;
    };
    const auto ride_on = [&](std::uint32_t frame) {
        ride(frame, away(frame), turned(match.covariance, -map_.poses[frame].phi_rad));
    };
    const std::uint32_t before = rides_on();
    const bool named = decisions_.is_named(stamp_ns_);
    // What shows nothing adds nothing to the map; frames there only let a correction be spread along the way.
    if (static_cast<int>(frame_.points.size()) < settings_.forward.min_returns && !named &&
        away(before).translation().norm() < settings_.blind_way_m)
        return ride(before, away(before), since_frame_.covariance);
    const bool map_is_right = match.matched && match.fit >= settings_.new_fit;
    if (is_near(away(before)) && !named) return ride_on(before);
    if (map_is_right && !named)
        if (const auto other = near_frame(match.T_map_base)) {
            ride_on(*other);
            since_frame_ = {latest_.T_frame_base, Eigen::Map<const Eigen::Matrix3d>(latest_.covariance)};
            return;
        }
    add_frame(match);
    ride(map_.last(), Pose2{}, turned(match.covariance, -map_.poses[map_.last()].phi_rad));
}

/// The frame that a scan may ride on: the nearest if it is near, or, where earlier visits have left enough of
/// them, the nearest of the place. So what a place costs does not grow from visit to visit.
std::optional<std::uint32_t> GridSlam::near_frame(const Pose2& T_map_base) const {
    std::optional<std::uint32_t> nearest;
    double nearest_away = known_around;
    std::size_t known = 0;
    for (const std::uint32_t frame : active_.active()) {
        const double way =
            (map_.poses[frame].translation() - T_map_base.translation()).norm() / settings_.frame_way_m;
        if (way >= known_around) continue;
        const double turn =
            std::abs(wrap_to_pi(map_.poses[frame].phi_rad - T_map_base.phi_rad)) / settings_.frame_turn_rad;
        const double away = std::max(way, turn);
        if (away >= known_around) continue;
        known += way_m_ - map_.path_m[frame] > settings_.links.visit_m ? 1 : 0;
        if (away >= nearest_away) continue;
        nearest_away = away;
        nearest = frame;
    }
    if (nearest_away < 1 || known >= settings_.known_frames) return nearest;
    return std::nullopt;
}

void GridSlam::add_frame(const ForwardMatch& match) {
    const bool first = map_.size() == 0;
    const std::uint32_t rode_on = first ? 0 : rides_on();
    const std::uint32_t frame =
        map_.add(frame_, match.T_map_base, way_m_, places_.size(), stamp_ns_, since_last_frame_);
    since_last_frame_ = {};
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
    if (!correction_ && found_.empty()) look_for_loop();
}

/// S3 and S4: is this an old place, as somebody says or by itself?
void GridSlam::look_for_loop() {
    if (const auto named = decisions_.due(stamp_ns_)) {
        found_ = loops_.look_at(decisions_.old_frame(*named), map_, active_, neighbourhood_);
        decisions_.tried(*named, loops_.records().size() - 1);
        return;
    }
    if (decisions_.search_is_off(stamp_ns_)) return;
    const std::size_t before = loops_.records().size();
    found_ = loops_.look(map_, active_, neighbourhood_);
    if (loops_.records().size() == before || !found_.empty() || !loops_.latest_waits()) return;
    const LoopRecord& latest = loops_.records().back();
    if (decisions_.refuses(map_, latest.old_frame, latest.frame)) loops_.refuse_latest(by_the_ini);
}

bool GridSlam::loop_at_hand_is_refused() const {
    return decisions_.refuses(map_, found_.back().from, found_.back().to);
}

/// Not before the scan that found it is done with, so that a state in between can go on either way (row B13).
/// How the vehicle was moved, if that was done at once.
std::optional<Pose2> GridSlam::close_loop() {
    const bool refused = loop_at_hand_is_refused();
    const std::vector<Constraint> loop = std::move(found_);
    found_.clear();
    if (refused) {
        loops_.refuse_latest(by_the_ini);
        return std::nullopt;
    }
    loop_ = loop.back();
    if (settings_.weights != Weights::joint) {
        const Pose2 T_new_old = correct_by_going_back(loop_);
        for (const Constraint& constraint : loop) add_constraint(constraint);
        active_.choose(map_, neighbourhood_, map_.last());
        return T_new_old;
    }
    for (const Constraint& constraint : loop) add_constraint(constraint);
    if (is_worth_correcting(loop_)) {
        relink_after_ = true;
        begin_correction();
    } else {
        active_.choose(map_, neighbourhood_, loop_.to);
        relink(loop_.to);
    }
    return std::nullopt;
}

/// S4 to S7: from the end of the loop back to its beginning, and what both ways say together.
Pose2 GridSlam::correct_by_going_back(const Constraint& closing) {
    Loop loop;
    loop.first = closing.from;
    loop.last = closing.to;
    loop.T_map_last = map_.poses[loop.first] * closing.T_from_to;
    loop.covariance = turned((closing.information + 1e-6 * Eigen::Matrix3d::Identity()).inverse(),
                             map_.poses[loop.first].phi_rad);

    std::vector<std::uint32_t> old_map;
    for (std::uint32_t frame = 0; frame < loop.first; ++frame) old_map.push_back(frame);
    WheelReverse by_wheels(map_);
    ReverseNavigation& navigation = reverse_navigation_ != nullptr ? *reverse_navigation_ : by_wheels;
    PassResult reverse = reverse_pass(map_, old_map, loop, navigation, settings_.forward, settings_.cell_m);

    // How far each way can be trusted: by the constraints along it, from where it began.
    PassResult forward;
    RelativeUncertainty from_first, from_last;
    relative_uncertainty(neighbourhood_, map_.poses, loop.first, RelativeUncertainty::unknown, from_first);
    relative_uncertainty(neighbourhood_, map_.poses, loop.last, RelativeUncertainty::unknown, from_last);
    for (std::uint32_t frame = loop.first; frame <= loop.last; ++frame) {
        forward.poses.push_back(map_.poses[frame]);
        forward.covariances.push_back(from_first.covariance[frame]);
        const Eigen::Matrix3d carried =
            carried_by(map_.poses[frame].translation() - map_.poses[loop.last].translation());
        reverse.covariances[frame - loop.first] =
            from_last.covariance[frame] + carried * loop.covariance * carried.transpose();
    }
    const PassResult fused = fuse(forward, reverse, settings_.weights);

    const std::vector<Pose2> before = map_.poses;
    std::vector<Pose2> after = map_.poses;
    std::copy(fused.poses.begin(), fused.poses.end(), after.begin() + loop.first);
    const Pose2 T_new_old = take_poses(std::move(after));
    record_correction(before, closing, reverse);
    return T_new_old;
}

/// Poses are kept of the corrections that moved the vehicle most: those are looked at.
void GridSlam::record_correction(const std::vector<Pose2>& before, const Constraint& loop,
                                 const PassResult& reverse) {
    constexpr std::ptrdiff_t most = 12;
    Correction correction;
    correction.stamp_ns = stamp_ns_;
    correction.old_frame = loop.from;
    correction.frame = loop.to;
    correction.T_before_after = before[loop.to].inverse() * map_.poses[loop.to];
    correction.reverse_first = reverse.poses.empty() ? 0 : loop.from;
    const auto moves_m = [](const Correction& c) { return c.T_before_after.translation().norm(); };

    const auto kept = std::count_if(corrections_.begin(), corrections_.end(),
                                    [](const Correction& c) { return c.before.count > 0; });
    Correction* least = nullptr;
    if (kept >= most)
        for (Correction& c : corrections_)
            if (c.before.count > 0 && (least == nullptr || moves_m(c) < moves_m(*least))) least = &c;
    if (least == nullptr || moves_m(*least) <= moves_m(correction)) {
        if (least != nullptr) least->before = least->after = least->reverse = {};
        correction.before = set_aside(before);
        correction.after =
            set_aside({map_.poses.begin(), map_.poses.begin() + static_cast<std::ptrdiff_t>(before.size())});
        correction.reverse = set_aside(reverse.poses);
    }
    corrections_.push_back(correction);
}

PosesAside GridSlam::set_aside(const std::vector<Pose2>& poses) {
    const PosesAside part{correction_poses_.size(), poses.size()};
    for (const Pose2& T_map_base : poses) correction_poses_.push_back(T_map_base);
    return part;
}

std::vector<Pose2> GridSlam::poses_of(const PosesAside& part) const {
    std::vector<Pose2> poses;
    poses.reserve(part.count);
    correction_poses_.for_each(part.first, part.first + part.count,
                               [&poses](const Pose2& T_map_base) { poses.push_back(T_map_base); });
    return poses;
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
std::optional<Pose2> GridSlam::advance() {
    if (!found_.empty())
        if (const auto T_new_old = close_loop()) return T_new_old;
    if (!correction_ || correction_->iterate()) return std::nullopt;
    return apply_correction();
}

Pose2 GridSlam::apply_correction() {
    Pose2 T_new_old;
    if (correction_->good()) {
        const std::vector<Pose2> before = map_.poses;
        T_new_old = take_poses(correction_->poses());
        record_correction(before, loop_);
    }
    correction_.reset();
    if (!relink_after_) return T_new_old;
    relink_after_ = false;
    const std::size_t before = constraints_.size();
    relink(loop_.to);
    const bool again =
        std::any_of(constraints_.begin() + static_cast<std::ptrdiff_t>(before), constraints_.end(),
                    [this](const Constraint& c) { return is_worth_correcting(c); });
    if (again) begin_correction();
    return T_new_old;
}

/// S7: all frames at their corrected poses; those taken since move with the last one, and so does the
/// vehicle.
Pose2 GridSlam::take_poses(std::vector<Pose2> corrected) {
    const Pose2 T_map_frame_before = map_.poses[rides_on()];
    const std::size_t last = corrected.size() - 1;
    const Pose2 T_new_old = corrected[last] * map_.poses[last].inverse();
    for (std::size_t k = corrected.size(); k < map_.size(); ++k) map_.poses[k] = T_new_old * map_.poses[k];
    std::copy(corrected.begin(), corrected.end(), map_.poses.begin());
    rebuild_neighbourhood();
    active_.choose(map_, neighbourhood_, map_.last());
    loops_.forget_pending();
    return map_.poses[rides_on()] * T_map_frame_before.inverse();
}

void GridSlam::relink(std::uint32_t from_frame) {
    for (std::uint32_t frame = map_.last();
         frame > 0 && map_.path_m[from_frame] - map_.path_m[frame] < settings_.relink_m; --frame)
        for (const Constraint& link : linker_.link(map_, active_, frame)) add_constraint(link);
}

void GridSlam::rebuild_neighbourhood() {
    neighbourhood_.clear();
    neighbourhood_.resize(map_.size());
    for (const Constraint& constraint : constraints_)
        neighbourhood_.add(constraint, map_.poses[constraint.from]);
}

void GridSlam::finish() {
    while (correction_ || !found_.empty()) advance();
    if (map_.size() < 2) {
        frame_covariances_.assign(map_.size(), Eigen::Matrix3d::Zero());
        return;
    }
    if (settings_.weights != Weights::joint) {
        // What the passes gave stays; what is known of each frame is so from the first one, by the
        // constraints.
        RelativeUncertainty known;
        relative_uncertainty(neighbourhood_, map_.poses, 0, RelativeUncertainty::unknown, known);
        frame_covariances_ = known.covariance;
        return;
    }
    GraphOptimiser final_fit(map_.poses, constraints_, settings_.graph);
    while (final_fit.iterate()) {
    }
    if (final_fit.good()) map_.poses = final_fit.poses();
    frame_covariances_ = final_fit.covariances();
    frame_covariances_.resize(map_.size(), Eigen::Matrix3d::Zero());
}

GridSlam::KnownPose GridSlam::latest(std::size_t scan) const {
    const Place place = places_[scan];
    const Pose2& T_map_frame = map_.poses[place.frame];
    const Pose2 T_map_base = T_map_frame * place.T_frame_base;
    const Eigen::Matrix3d carried = carried_by(T_map_base.translation() - T_map_frame.translation());
    Eigen::Matrix3d covariance =
        turned(Eigen::Map<const Eigen::Matrix3d>(place.covariance), T_map_frame.phi_rad);
    if (place.frame < frame_covariances_.size())
        covariance += carried * frame_covariances_[place.frame] * carried.transpose();
    return {T_map_base, covariance};
}

void GridSlam::path(std::vector<Pose2>& poses, std::vector<Eigen::Matrix3d>& covariances) const {
    poses.clear();
    covariances.clear();
    for (std::size_t scan = 0; scan < scans(); ++scan) {
        const KnownPose known = latest(scan);
        poses.push_back(known.T_map_base);
        covariances.push_back(known.covariance);
    }
}

}  // namespace loopline::grid_slam
