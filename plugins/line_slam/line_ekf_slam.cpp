#include "line_slam/line_ekf_slam.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "least_squares/chi_square.h"

namespace loopline::line_slam {
namespace {

constexpr double rounding_m = 1e-6;  // of lengths of the path

}  // namespace

LineEkfSlam::LineEkfSlam(const LineSlamParameters& parameters)
    : parameters_(parameters),
      filter_(EkfParameters{parameters.drive, parameters.feature, parameters.update}),
      tentative_(parameters.tentative) {
    history_.drive = parameters.drive;
}

SlamStatus LineEkfSlam::step(const Pose2& T_previous_base, std::vector<LineObservation> observations) {
    const WheelTravel travel = wheel_travel(T_previous_base, parameters_.drive.track_width_m);
    return step({{travel, travel_covariance(travel, parameters_.drive)}}, std::move(observations));
}

SlamStatus LineEkfSlam::step(const std::vector<MotionPiece>& motion,
                             std::vector<LineObservation> observations) {
    const double way_m = predict(motion);
    discount_repetition(way_m, observations);
    activate_surroundings(observations);
    const Association association = associate_or_doubt_wheels(observations, way_m);
    if (!association.pairings.empty()) {
        if (!filter_.update(association.pairings, observations)) return SlamStatus::diverged;
        ++counts_.updates;
    }
    counts_.associations += static_cast<std::int64_t>(association.pairings.size());
    counts_.rejected += association.refused;
    // Two walls or more tell the motion better than the wheels do.
    if (association.pairings.size() < 2) tentative_.move(filter_.motion_error_covariance());
    remember_seen(association.pairings, observations);

    std::vector<int> tracks(observations.size(), no_track);
    for (const Pairing& p : association.pairings)
        tracks[static_cast<std::size_t>(p.observation)] = records_[static_cast<std::size_t>(p.line)].track;
    augment_map(association, observations, tracks);
    drop_chance_lines();
    recognise_old_place();
    wake_neighbourhood();

    HistoryStep& recorded = history_.steps.back();
    recorded.T_map_base = filter_.T_map_base();
    history_.calibration = filter_.calibration();
    recorded.observations = std::move(observations);
    recorded.tracks = std::move(tracks);
    ++scan_;
    return filter_.is_sound() ? SlamStatus::good : SlamStatus::diverged;
}

double LineEkfSlam::predict(const std::vector<MotionPiece>& motion) {
    filter_.predict(motion);
    ++counts_.predictions;
    history_.steps.emplace_back();
    HistoryStep& recorded = history_.steps.back();
    const double track_width_m = parameters_.drive.track_width_m;
    Pose2 T_previous_base;
    double way_m = 0;
    for (const MotionPiece& piece : motion) {
        const Pose2 T_piece = moved(piece.travel, track_width_m);
        T_previous_base = T_previous_base * T_piece;
        recorded.travel_covariance += piece.covariance;
        way_m += T_piece.translation().norm();
    }
    recorded.travel = motion.size() == 1 ? motion[0].travel : wheel_travel(T_previous_base, track_width_m);
    path_m_ += way_m;
    return way_m;
}

/// A wall's unevenness looks the same from the next scan: over one correlation length of the path, all
/// sightings together tell as much about the wall as one with this error.
void LineEkfSlam::discount_repetition(double way_m, std::vector<LineObservation>& observations) const {
    const double scans = parameters_.wall_correlation_m / std::max(way_m, 1e-3);
    const double repetitions = std::min(std::max(scans, 1.0), parameters_.max_repetitions);
    for (LineObservation& z : observations) z.surplus = (repetitions - 1) * z.wall_covariance;
}

/// If walls are not where the wheels say, but several are where one slip of the wheels, or one bump of the
/// ground, puts them, that is what happened.
Association LineEkfSlam::associate_or_doubt_wheels(const std::vector<LineObservation>& observations,
                                                   double way_m) {
    Association association = associate(filter_, records_, observations, parameters_.association);
    const std::size_t before = last_pairings_;
    last_pairings_ = association.pairings.size();
    const bool walls_are_missed =
        association.pairings.size() < before && association.pairings.size() + 2 <= observations.size();
    // With vague wheels other walls are in reach of a slip: it is looked for only where nothing is left to
    // lose.
    if (!walls_are_missed || !(slip_is_small() || association.pairings.empty())) return association;

    const double slip2 = parameters_.slip_factor * parameters_.slip_factor;
    filter_.doubt_motion(slip2 - 1);
    Association with_slip = associate(filter_, records_, observations, parameters_.association);
    if (tells_of_slip(with_slip, association, path_m_ - way_m - rounding_m)) {
        last_pairings_ = with_slip.pairings.size();
        history_.steps.back().travel_covariance *= slip2;
        ++counts_.slips;
        return with_slip;
    }
    filter_.doubt_motion(1 - slip2);
    return association;
}

/// A slip by the wheels' noise times slip_factor turns the vehicle by less than what reaches other walls.
bool LineEkfSlam::slip_is_small() const {
    const Eigen::Matrix3d& Q = history_.steps.back().travel_covariance;
    const double turn_variance =
        (Q(0, 0) + Q(1, 1) - 2 * Q(0, 1)) / std::pow(parameters_.drive.track_width_m, 2);
    return parameters_.slip_factor * std::sqrt(turn_variance) < parameters_.max_slip_turn_rad;
}

/// Two walls or more that the last step saw come back together, and more than fit without the slip: as they
/// agree on its turn and on its shift across them, that is no chance. (Where it is the minority that is off,
/// the walls are not as straight as they should be.) Or any two that cross, where there was nothing at all
/// without it.
bool LineEkfSlam::tells_of_slip(const Association& with_slip, const Association& without,
                                double path_at_last_step_m) const {
    std::vector<bool> paired(with_slip.is_compatible.size(), false);
    for (const Pairing& p : without.pairings) paired[static_cast<std::size_t>(p.observation)] = true;
    std::size_t back = 0;
    for (const Pairing& p : with_slip.pairings)
        back += !paired[static_cast<std::size_t>(p.observation)] &&
                records_[static_cast<std::size_t>(p.line)].last_seen_m >= path_at_last_step_m;
    if (back >= 2 && back > without.pairings.size() &&
        with_slip.pairings.size() >= without.pairings.size() + 2)
        return true;
    if (!without.pairings.empty()) return false;
    for (const Pairing& a : with_slip.pairings)
        for (const Pairing& b : with_slip.pairings)
            if (std::abs(std::sin(filter_.line(a.line).alpha_rad - filter_.line(b.line).alpha_rad)) > 0.5)
                return true;
    return false;
}

/// Could one of the observations be of this line, with `reach_m` of leeway?
bool LineEkfSlam::may_be_seen(int id, const std::vector<LineObservation>& observations,
                              double reach_m) const {
    const PlanarLine predicted = predicted_line(filter_.T_map_base(), filter_.line(id));
    const Eigen::Vector2d n = predicted.normal(), t = predicted.tangent();
    const double shift_m = filter_.line(id).along_m(filter_.T_map_base().translation());
    const Extent& seen = records_[static_cast<std::size_t>(id)].extent;
    for (const LineObservation& z : observations) {
        const double a_m = t.dot(z.start_m) + shift_m, b_m = t.dot(z.end_m) + shift_m;
        if (std::abs(n.dot(z.middle_m()) - predicted.rho_m) < reach_m &&
            seen.overlap_m({std::min(a_m, b_m), std::max(a_m, b_m)}) > -reach_m &&
            std::abs(wrap_to_pi(z.line.alpha_rad - predicted.alpha_rad)) < 0.5)
            return true;
    }
    return false;
}

/// Passive lines that an observation might see join the active ones. When these have become too many, those
/// go that can't be seen now and were not on the last metres.
void LineEkfSlam::activate_surroundings(const std::vector<LineObservation>& observations) {
    const double reach_m =
        1.0 + 3 * std::sqrt(std::max(0.0, filter_.pose_covariance().topLeftCorner<2, 2>().trace()));
    const auto relevant = [&](int id) {
        return records_[static_cast<std::size_t>(id)].awake && may_be_seen(id, observations, reach_m);
    };
    std::vector<int> wanted;
    for (const int id : awake_)
        if (filter_.exists(id) && !filter_.is_active(id) && relevant(id)) wanted.push_back(id);
    if (!wanted.empty()) filter_.activate_also(wanted);
    if (filter_.active_lines().size() < active_limit_) return;
    wanted.clear();
    for (const int id : filter_.active_lines())
        if (path_m_ - records_[static_cast<std::size_t>(id)].last_seen_m < parameters_.active_m ||
            relevant(id))
            wanted.push_back(id);
    filter_.activate(wanted);
    active_limit_ = wanted.size() + 20;
}

void LineEkfSlam::remember_seen(const std::vector<Pairing>& pairings,
                                const std::vector<LineObservation>& observations) {
    const Pose2& T = filter_.T_map_base();
    for (const Pairing& p : pairings) {
        MapLineRecord& record = records_[static_cast<std::size_t>(p.line)];
        const LineObservation& z = observations[static_cast<std::size_t>(p.observation)];
        record.extent.extend(Extent::of(filter_.line(p.line), T * z.start_m, T * z.end_m));
        ++record.observations;
        record.last_seen_m = path_m_;
        record.recent = true;
        remember_place(p.line, static_cast<int>(path_m_));
    }
}

void LineEkfSlam::remember_place(int id, int place) {
    std::vector<int>& places = records_[static_cast<std::size_t>(id)].places;
    if (!places.empty() && places.back() == place) return;
    places.push_back(place);
    if (lines_at_.size() <= static_cast<std::size_t>(place))
        lines_at_.resize(static_cast<std::size_t>(place) + 1);
    lines_at_[static_cast<std::size_t>(place)].push_back(id);
}

void LineEkfSlam::augment_map(const Association& association,
                              const std::vector<LineObservation>& observations, std::vector<int>& tracks) {
    const Pose2& T = filter_.T_map_base();
    for (std::size_t i = 0; i < observations.size(); ++i) {
        if (tracks[i] != no_track) continue;
        const TentativeLine& t = tentative_.add(T, observations[i], scan_, history_.track_count);
        tracks[i] = t.track;
        if (!tentative_.is_confirmed(t) || association.is_compatible[i]) continue;
        const int id = filter_.augment(observations[i]);
        records_.push_back({t.extent, t.track, t.scans, path_m_, {}, true});
        remember_place(id, static_cast<int>(path_m_));
        awake_.push_back(id);
        young_.push_back(id);
        tentative_.remove(t.track);
    }
    tentative_.forget_stale(scan_);
}

/// Lines that a few scans agreed on but the next ones did not: clutter and moving things.
void LineEkfSlam::drop_chance_lines() {
    constexpr int established = 10;  // sightings
    const auto decided = [&](int id) {
        const MapLineRecord& record = records_[static_cast<std::size_t>(id)];
        if (!filter_.exists(id) || record.observations >= established) return true;
        if (path_m_ - record.last_seen_m < 1.0) return false;
        filter_.remove(id);
        ++counts_.dropped;
        return true;
    };
    young_.erase(std::remove_if(young_.begin(), young_.end(), decided), young_.end());
}

/// All matches at once; refused if they are farther from what the filter believes than even an overconfident
/// one errs.
bool LineEkfSlam::merge(const Recognition& recognition) {
    std::vector<Ekf::SameWall> walls;
    std::vector<PlanarLine> gone_lines;
    const double variance_m2 = parameters_.sigma_wall_m * parameters_.sigma_wall_m;
    for (const auto& [gone, kept] : recognition.matches) {
        if (!filter_.is_active(kept)) continue;
        const Extent& drop = records_[static_cast<std::size_t>(gone)].extent;
        const double length_m = std::max(
            0.5, std::min(records_[static_cast<std::size_t>(kept)].extent.length_m(), drop.length_m()));
        Eigen::Matrix2d about_middle;
        about_middle << 1, 0.5 * (drop.from_m + drop.to_m), 0, 1;
        const Eigen::Vector2d slack(variance_m2, 4 * variance_m2 / (length_m * length_m));
        walls.push_back({kept, gone, about_middle * slack.asDiagonal() * about_middle.transpose()});
        gone_lines.push_back(filter_.line(gone));
    }
    const double bound = parameters_.overconfidence * parameters_.overconfidence *
                         least_squares::chi_square_quantile(2 * static_cast<double>(walls.size()), 0.999);
    if (walls.empty() || filter_.same_wall_distance2(walls) > bound || !filter_.merge(walls)) return false;
    for (std::size_t k = 0; k < walls.size(); ++k) {
        MapLineRecord& keep = records_[static_cast<std::size_t>(walls[k].kept)];
        const MapLineRecord& drop = records_[static_cast<std::size_t>(walls[k].gone)];
        keep.extent.extend(Extent::of(filter_.line(walls[k].kept), gone_lines[k].point_m(drop.extent.from_m),
                                      gone_lines[k].point_m(drop.extent.to_m)));
        keep.observations += drop.observations;
        keep.last_seen_m = std::max(keep.last_seen_m, drop.last_seen_m);
        for (const int place : drop.places)
            lines_at_[static_cast<std::size_t>(place)].push_back(walls[k].kept);
        keep.places.insert(keep.places.end(), drop.places.begin(), drop.places.end());
        std::sort(keep.places.begin(), keep.places.end());
        if (!keep.awake) awake_.push_back(walls[k].kept);
        keep.awake = true;
        history_.same_wall.emplace_back(keep.track, drop.track);
        ++counts_.merged;
    }
    return true;
}

void LineEkfSlam::recognise_old_place() {
    if (path_m_ - recognised_at_m_ < parameters_.recognition_every_m) return;
    recognised_at_m_ = path_m_;
    const auto found = search_old_place();
    if (!found) return;
    // Once more with the present values: passive lines lag behind.
    std::vector<int> wanted;
    for (const auto& [id_recent, id_old] : found->matches) wanted.push_back(id_old);
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    filter_.activate_also(wanted);
    const auto confirmed = search_old_place();
    if (!confirmed) return;
    if (!merge(*confirmed)) {
        ++counts_.refused;
        return;
    }
    ++counts_.recognised;
    filter_.refresh_passive_lines();
    for (int id = 0; id < filter_.line_ids(); ++id)
        if (filter_.exists(id)) put_on_grid(id);
    woken_at_m_ = -1;
}

void LineEkfSlam::put_on_grid(int id) {
    const Extent& seen = records_[static_cast<std::size_t>(id)].extent;
    grid_.add(id, filter_.line(id).point_m(seen.from_m), filter_.line(id).point_m(seen.to_m));
}

/// Lines of the last `way_m` of the path, ascending.
std::vector<int> LineEkfSlam::lines_since(double way_m) const {
    std::vector<int> ids;
    for (auto place = static_cast<std::size_t>(std::max(0.0, path_m_ - way_m)); place < lines_at_.size();
         ++place)
        for (const int id : lines_at_[place])
            if (filter_.exists(id) && path_m_ - records_[static_cast<std::size_t>(id)].last_seen_m <= way_m)
                ids.push_back(id);
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
}

std::optional<Recognition> LineEkfSlam::search_old_place() {
    RecognitionParameters p = parameters_.recognition;
    const Eigen::Vector2d here_m = filter_.T_map_base().translation();
    const auto place_line = [&](int id) {
        return PlaceLine{id, filter_.line(id), records_[static_cast<std::size_t>(id)].extent};
    };
    std::vector<PlaceLine> recent, old;
    Eigen::AlignedBox2d box(here_m, here_m);
    for (const int id : lines_since(parameters_.recent_m)) {
        put_on_grid(id);
        if (!filter_.is_active(id)) continue;
        recent.push_back(place_line(id));
        const PlaceLine& l = recent.back();
        box.extend(l.line.point_m(l.extent.from_m));
        box.extend(l.line.point_m(l.extent.to_m));
    }
    // How far off an old place may be: what dead reckoning may have drifted since, but no more than the
    // filter can doubt its own pose.
    const Eigen::Matrix3d covariance = filter_.pose_covariance();
    const double doubt = parameters_.overconfidence;
    const double doubt_m = doubt * std::sqrt(std::max(0.0, covariance.topLeftCorner<2, 2>().trace()));
    const double doubt_rad = doubt * std::sqrt(std::max(0.0, covariance(2, 2)));
    const double shift_m = p.max_shift_m + std::min(doubt_m, parameters_.drift_m_per_m * path_m_);
    const double turn_rad = p.max_turn_rad + std::min(doubt_rad, parameters_.drift_rad_per_m * path_m_);
    const double margin_m = shift_m + turn_rad * box.diagonal().norm();
    double unseen_m = 0;
    for (const int id : grid_.in_box(box.min().array() - margin_m, box.max().array() + margin_m)) {
        if (!filter_.exists(id)) continue;
        const double since_m = path_m_ - records_[static_cast<std::size_t>(id)].last_seen_m;
        if (since_m <= parameters_.recent_m) continue;
        old.push_back(place_line(id));
        unseen_m = std::max(unseen_m, since_m);
    }
    p.max_shift_m = std::min(shift_m, p.max_shift_m + parameters_.drift_m_per_m * unseen_m);
    p.max_turn_rad = std::min(turn_rad, p.max_turn_rad + parameters_.drift_rad_per_m * unseen_m);
    return recognise_place(recent, old, here_m, p);
}

/// What is seen now was also seen from there: lines of around there may be seen next.
void LineEkfSlam::wake_neighbourhood() {
    if (path_m_ - woken_at_m_ < 0.5 && woken_at_m_ >= 0) return;
    woken_at_m_ = path_m_;
    for (const int id : awake_) {
        records_[static_cast<std::size_t>(id)].awake = false;
        records_[static_cast<std::size_t>(id)].recent = false;
    }
    awake_.clear();
    near_.assign(lines_at_.size(), false);
    const int reach = static_cast<int>(parameters_.wake_m), last = static_cast<int>(lines_at_.size()) - 1;
    const auto wake_around = [&](int place) {
        for (int p = std::max(0, place - reach); p <= std::min(place + reach, last); ++p) {
            const auto near = static_cast<std::size_t>(p);
            if (near_[near]) continue;
            near_[near] = true;
            for (const int id : lines_at_[near]) {
                MapLineRecord& record = records_[static_cast<std::size_t>(id)];
                if (record.awake || !filter_.exists(id)) continue;
                record.awake = true;
                awake_.push_back(id);
            }
        }
    };
    wake_around(static_cast<int>(path_m_));
    for (const int id : lines_since(2.0))
        for (const int place : records_[static_cast<std::size_t>(id)].places) wake_around(place);
    std::sort(awake_.begin(), awake_.end());
    for (const int id : awake_) {
        MapLineRecord& record = records_[static_cast<std::size_t>(id)];
        record.recent = path_m_ - record.last_seen_m < parameters_.recent_m;
    }
}

}  // namespace loopline::line_slam
