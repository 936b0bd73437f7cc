#include "grid_slam/links.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace loopline::grid_slam {

/// Of frame `from` and those beside it, in its own frame. What was taken at about the same time as `to` is of
/// no use.
void Linker::take_surfaces(const MapFrames& map, std::uint32_t from, std::uint32_t to) {
    const std::uint32_t first = from - std::min(from, settings_.beside),
                        last =
                            std::min({from + settings_.beside, map.last(), from < to ? to - 1 : map.last()});
    const Pose2 T_from_map = map.poses[from].inverse();
    surfaces_.clear();
    for (std::uint32_t frame = first; frame <= last; ++frame)
        if (frame != to && std::abs(map.path_m[frame] - map.path_m[from]) <= settings_.beside_m)
            surfaces_.add(map.frames[frame], T_from_map * map.poses[frame]);
    surfaces_.finish();
}

std::optional<Constraint> Linker::match(const MapFrames& map, std::uint32_t from, std::uint32_t to) {
    ++tried_;
    take_surfaces(map, from, to);
    const Pose2 T_from_to = map.poses[from].inverse() * map.poses[to];
    // Where the scans leave a direction open, it stays about where it is.
    const Eigen::Matrix3d weak = Eigen::Vector3d(1 / 0.25, 1 / 0.25, 1 / 0.01).asDiagonal();
    auto fit = grid_map::refine(surfaces_, map.frames[to], T_from_to, T_from_to, weak, settings_.refinement);
    if (!fit.converged || fit.fit < settings_.min_fit || fit.used < settings_.min_returns)
        return std::nullopt;
    const double range_m = grid_map::mean_range_m(map.frames[to]);
    if (grid_map::degeneracy(fit, range_m, settings_.sigma_degenerate_m).free_directions > 0)
        grid_map::forget_free_directions(fit, T_from_to, range_m, settings_.sigma_degenerate_m);
    Constraint constraint;
    constraint.from = from;
    constraint.to = to;
    constraint.kind = Constraint::Kind::match;
    constraint.information = fit.information;
    // The optimum of the scans alone, without the pull of `weak`.
    const Eigen::Vector3d off =
        (fit.information + 1e-3 * Eigen::Matrix3d::Identity()).ldlt().solve(fit.gradient);
    constraint.T_from_to = fit.T_map_base;
    if (off.head<2>().norm() < settings_.refinement.reach_m)
        constraint.T_from_to = {fit.T_map_base.x_m + off.x(), fit.T_map_base.y_m + off.y(),
                                wrap_to_pi(fit.T_map_base.phi_rad + off.z())};
    return constraint;
}

/// The nearest frame of each earlier visit, a turn of 1 rad being as far as 1 m.
std::vector<std::uint32_t> Linker::earlier_visits(const MapFrames& map, const ActiveMap& active,
                                                  std::uint32_t frame) const {
    std::vector<std::pair<double, std::uint32_t>> near;
    for (const std::uint32_t other : active.active()) {
        if (std::abs(map.path_m[frame] - map.path_m[other]) < settings_.earlier_m) continue;
        const double away = map.distance_m(other, frame) + map.turn_rad(other, frame);
        if (away < settings_.max_distance_m) near.emplace_back(away, other);
    }
    std::sort(near.begin(), near.end());
    std::vector<std::uint32_t> chosen;
    for (const auto& [away, other] : near) {
        if (static_cast<int>(chosen.size()) == settings_.visits) break;
        const bool same_visit = std::any_of(chosen.begin(), chosen.end(), [&, o = other](std::uint32_t c) {
            return std::abs(map.path_m[c] - map.path_m[o]) < settings_.visit_m;
        });
        if (!same_visit) chosen.push_back(other);
    }
    return chosen;
}

std::vector<Constraint> Linker::link(const MapFrames& map, const ActiveMap& active, std::uint32_t frame) {
    std::vector<std::uint32_t> others;
    for (const std::uint32_t back : settings_.steps_back)
        if (frame >= back && map.distance_m(frame - back, frame) < settings_.max_distance_m)
            others.push_back(frame - back);
    if (frame >= settings_.long_step &&
        map.distance_m(frame - settings_.long_step, frame) < settings_.long_step_m)
        others.push_back(frame - settings_.long_step);
    for (const std::uint32_t other : earlier_visits(map, active, frame)) others.push_back(other);
    std::vector<Constraint> constraints;
    for (const std::uint32_t other : others) {
        if (!known_.insert(std::minmax(other, frame)).second) continue;
        if (const auto constraint = match(map, std::min(other, frame), std::max(other, frame)))
            constraints.push_back(*constraint);
    }
    return constraints;
}

}  // namespace loopline::grid_slam
