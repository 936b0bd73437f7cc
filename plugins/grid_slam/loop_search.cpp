#include "grid_slam/loop_search.h"

#include <algorithm>
#include <cmath>

namespace loopline::grid_slam {
namespace {

/// A frame as if it had been taken from another place.
void append_moved(const grid_map::Frame& frame, const Pose2& T_to_from, grid_map::Frame& to) {
    const auto c = static_cast<float>(std::cos(T_to_from.phi_rad)),
               s = static_cast<float>(std::sin(T_to_from.phi_rad)), x = static_cast<float>(T_to_from.x_m),
               y = static_cast<float>(T_to_from.y_m);
    for (const auto& p : frame.points)
        to.points.push_back(
            {{x + c * p.p_base_m.x() - s * p.p_base_m.y(), y + s * p.p_base_m.x() + c * p.p_base_m.y()},
             {c * p.normal_base.x() - s * p.normal_base.y(), s * p.normal_base.x() + c * p.normal_base.y()}});
}

/// Standard deviation of the position along the direction that is held least, whatever the heading.
double sigma_of_weakest_direction_m(const Eigen::Matrix3d& information) {
    const double per_heading = 1 / std::max(information(2, 2), 1e-12);
    const double xx = information(0, 0) - information(0, 2) * information(0, 2) * per_heading,
                 xy = information(0, 1) - information(0, 2) * information(1, 2) * per_heading,
                 yy = information(1, 1) - information(1, 2) * information(1, 2) * per_heading;
    const double weakest = (xx + yy) / 2 - std::hypot((xx - yy) / 2, xy);
    return 1 / std::sqrt(std::max(weakest, 1e-12));
}

}  // namespace

/// The nearest frame that is not active, among those that the vehicle may be near.
std::optional<std::uint32_t> LoopSearch::candidate(const MapFrames& map, const ActiveMap& active,
                                                   const Neighbourhood& neighbourhood) {
    const std::uint32_t now = map.last();
    const auto may_be_near = [&](std::uint32_t frame, double sigma_m) {
        return map.distance_m(frame, now) < settings_.reach_m + settings_.window_sigmas * sigma_m;
    };
    // Errors grow by less than this part of the way: most of the time nothing is near, and no more needs to
    // be known.
    constexpr double growth = 0.05;
    const double at_most_m = largest_sigma_m_ + growth * (map.path_m[now] - known_at_m_);
    bool any = false;
    for (std::uint32_t frame = 0; frame < now && !any; ++frame)
        any = !active.is_active(frame) && may_be_near(frame, at_most_m);
    if (!any) return std::nullopt;

    relative_uncertainty(neighbourhood, map.poses, now, RelativeUncertainty::unknown, uncertainty_);
    known_at_m_ = map.path_m[now];
    largest_sigma_m_ = 0;
    for (std::uint32_t frame = 0; frame < now; ++frame)
        largest_sigma_m_ = std::max(largest_sigma_m_, std::sqrt(uncertainty_.variance_m2[frame]));

    std::optional<Candidate> best;
    for (std::uint32_t frame = 0; frame < now; ++frame) {
        if (active.is_active(frame) || !may_be_near(frame, std::sqrt(uncertainty_.variance_m2[frame])))
            continue;
        // A view from the same side is worth a way of two metres for a radian.
        const double away = map.distance_m(frame, now) + 2 * map.turn_rad(frame, now);
        if (!best || away < best->away) best = Candidate{frame, away};
    }
    if (!best) return std::nullopt;
    return best->old_frame;
}

grid_map::Frame LoopSearch::latest_frames(const MapFrames& map) const {
    grid_map::Frame latest;
    const std::uint32_t now = map.last();
    const Pose2 T_now_map = map.poses[now].inverse();
    for (std::uint32_t frame = now; map.path_m[now] - map.path_m[frame] < settings_.latest_m; --frame) {
        append_moved(map.frames[frame], T_now_map * map.poses[frame], latest);
        if (frame == 0) break;
    }
    return latest;
}

grid_map::SearchWindow LoopSearch::window(const MapFrames& map, std::uint32_t old_frame) const {
    grid_map::SearchWindow window;
    window.T_map_center = map.poses[old_frame].inverse() * map.poses[map.last()];
    const double sigma_m = std::sqrt(uncertainty_.variance_m2[old_frame]),
                 sigma_rad = std::sqrt(uncertainty_.covariance[old_frame](2, 2));
    const double half_m = std::min(settings_.max_window_m, settings_.window_sigmas * sigma_m + 0.2),
                 half_rad = std::min(settings_.max_window_rad, settings_.window_sigmas * sigma_rad + 0.02);
    window.cells_x = window.cells_y =
        static_cast<int>(std::ceil(std::max(settings_.least_window_m, half_m) / settings_.cell_m));
    window.heading_step_rad = 0.5 * M_PI / 180;
    window.headings =
        static_cast<int>(std::ceil(std::max(settings_.least_window_rad, half_rad) / window.heading_step_rad));
    return window;
}

/// Why a match can't be trusted; empty if nothing speaks against it.
std::string LoopSearch::objection(const grid_map::ScanGrid& old_map,
                                  const std::vector<Eigen::Vector2f>& points, grid_map::SearchWindow window,
                                  const grid_map::SearchResult& found, const grid_map::ScanFit& fit,
                                  LoopRecord& record) const {
    if (fit.fit < settings_.min_fit) return "too few returns lie on surfaces of the old map";
    if (!(sigma_of_weakest_direction_m(settings_.information_share * fit.information) <
          settings_.max_sigma_m))
        return "the scans don't hold the pose in all directions";
    const int apart = static_cast<int>(settings_.rival_m / old_map.cell_m());
    window.without = grid_map::SearchWindow::Exclusion{found.dx_cells, found.dy_cells, found.heading, apart,
                                                       static_cast<int>(0.1 / window.heading_step_rad)};
    window.min_score = static_cast<int>(settings_.rival * found.score);
    if (const auto rival = grid_map::branch_and_bound(old_map, points, window)) {
        record.rival = rival->fit;
        return "another place fits as well";
    }
    return {};
}

std::optional<Constraint> LoopSearch::match(const MapFrames& map, const ActiveMap& active,
                                            std::uint32_t old_frame) {
    const std::uint32_t now = map.last();
    grid_map::ScanGridSettings grid;
    grid.cell_m = settings_.cell_m;
    grid.free_space = false;
    grid_map::ScanGrid old_map(grid);
    const Pose2 T_old_map = map.poses[old_frame].inverse();
    for (std::uint32_t frame = 0; frame < now; ++frame)
        if (std::abs(map.path_m[frame] - map.path_m[old_frame]) < settings_.old_map_m &&
            !active.is_active(frame))
            old_map.insert(map.frames[frame], T_old_map * map.poses[frame]);

    const grid_map::Frame latest = latest_frames(map);
    const auto points = grid_map::search_points(latest, static_cast<std::size_t>(settings_.search_points));
    grid_map::SearchWindow where = window(map, old_frame);
    where.min_score = static_cast<int>(settings_.min_likelihood * grid_map::ScanGrid::full_likelihood *
                                       static_cast<double>(points.size()));
    const auto found = grid_map::branch_and_bound(old_map, points, where);
    if (!found) return std::nullopt;

    LoopRecord record;
    record.frame = now;
    record.old_frame = old_frame;
    record.way_m = map.path_m[now] - map.path_m[old_frame];
    record.likelihood = found->fit;
    record.sigma_m = std::sqrt(uncertainty_.variance_m2[old_frame]);
    record.sigma_rad = std::sqrt(uncertainty_.covariance[old_frame](2, 2));
    const auto fit = grid_map::refine(old_map, latest, found->T_map_base, found->T_map_base,
                                      Eigen::Matrix3d::Zero(), settings_.refinement);
    record.fit = fit.fit;
    record.shift << fit.T_map_base.x_m - where.T_map_center.x_m, fit.T_map_base.y_m - where.T_map_center.y_m,
        wrap_to_pi(fit.T_map_base.phi_rad - where.T_map_center.phi_rad);
    record.reason = objection(old_map, points, where, *found, fit, record);
    std::optional<Constraint> constraint;
    if (record.reason.empty()) {
        record.decision = LoopRecord::Decision::waits;
        record.reason = "waits for a second match that agrees";
        constraint = Constraint{old_frame, now, fit.T_map_base, settings_.information_share * fit.information,
                                Constraint::Kind::loop};
    }
    records_.push_back(record);
    return constraint;
}

std::vector<Constraint> LoopSearch::look(const MapFrames& map, const ActiveMap& active,
                                         const Neighbourhood& neighbourhood) {
    const double way_m = map.path_m[map.last()];
    if (way_m - looked_at_m_ < settings_.every_m * (pending_.empty() ? 1 : 0.5)) return {};
    looked_at_m_ = way_m;
    const auto old_frame = candidate(map, active, neighbourhood);
    if (!old_frame) return {};
    const auto found = match(map, active, *old_frame);
    if (!found) return {};
    std::vector<Constraint> loop;
    for (const Constraint& other : pending_) {
        // Matches of nearly the same scans make the same mistake.
        const double since_m = way_m - map.path_m[other.to];
        if (since_m < settings_.agree_after_m || since_m > settings_.agree_within_m) continue;
        // Both put the vehicle on the old map: what it drove between them must be the same.
        const Pose2 T_then_now = map.poses[other.to].inverse() * map.poses[found->to];
        const Pose2 by_loops =
            (map.poses[other.from] * other.T_from_to).inverse() * (map.poses[found->from] * found->T_from_to);
        const Pose2 apart = T_then_now.inverse() * by_loops;
        if (apart.translation().norm() < settings_.agree_m && std::abs(apart.phi_rad) < settings_.agree_rad)
            loop.push_back(other);
    }
    pending_.push_back(*found);
    if (loop.empty()) return {};
    loop.push_back(*found);
    records_.back().decision = LoopRecord::Decision::accepted;
    records_.back().reason = "two matches agree";
    pending_.clear();
    return loop;
}

std::vector<Constraint> LoopSearch::look_at(std::uint32_t old_frame, const MapFrames& map,
                                            const ActiveMap& active, const Neighbourhood& neighbourhood) {
    relative_uncertainty(neighbourhood, map.poses, map.last(), RelativeUncertainty::unknown, uncertainty_);
    const LoopSettings as_set = settings_;
    settings_.least_window_m = settings_.named_window_m;
    settings_.least_window_rad = settings_.named_window_rad;
    const std::size_t before = records_.size();
    const auto found = match(map, active, old_frame);
    settings_ = as_set;
    if (records_.size() == before) {
        LoopRecord record;
        record.frame = map.last();
        record.old_frame = old_frame;
        record.way_m = map.path_m[record.frame] - map.path_m[old_frame];
        record.sigma_m = std::sqrt(uncertainty_.variance_m2[old_frame]);
        record.sigma_rad = std::sqrt(uncertainty_.covariance[old_frame](2, 2));
        record.reason = active.is_active(old_frame) ? "that place is in the map at hand already"
                                                    : "the scans fit nowhere near there";
        records_.push_back(record);
    }
    if (!found) return {};
    records_.back().decision = LoopRecord::Decision::accepted;
    records_.back().reason = "named in the .ini";
    pending_.clear();
    std::vector<Constraint> loop{*found};
    loop.back().kind = Constraint::Kind::named;
    return loop;
}

void LoopSearch::refuse_latest(const std::string& reason) {
    if (records_.back().decision == LoopRecord::Decision::waits) pending_.pop_back();
    records_.back().decision = LoopRecord::Decision::refused;
    records_.back().reason = reason;
}

}  // namespace loopline::grid_slam
