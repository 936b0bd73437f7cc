#include "grid_slam/start_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace loopline::grid_slam {
namespace {

/// The frames of the last part of the way as one, as seen from the vehicle now; of those that lie close
/// together one is enough.
grid_map::Frame latest_frames_as_one(const MapFrames& frames, double way_m) {
    grid_map::Frame one;
    const std::uint32_t now = frames.last();
    const Pose2 T_now_local = frames.poses[now].inverse();
    constexpr double apart_m = 0.3, apart_rad = 10 * M_PI / 180;
    std::uint32_t kept = now;
    for (std::uint32_t k = now + 1; k-- > 0 && frames.path_m[now] - frames.path_m[k] <= way_m;) {
        if (k != now && frames.path_m[kept] - frames.path_m[k] < apart_m &&
            frames.turn_rad(kept, k) < apart_rad)
            continue;
        kept = k;
        const Pose2 T_now_then = T_now_local * frames.poses[k];
        const double c = std::cos(T_now_then.phi_rad), s = std::sin(T_now_then.phi_rad);
        for (const auto& p : frames.frames[k].points) {
            const Eigen::Vector2d n = p.normal_base.cast<double>();
            one.points.push_back(
                {(T_now_then * Eigen::Vector2d(p.p_base_m.cast<double>())).cast<float>(),
                 Eigen::Vector2d(c * n.x() - s * n.y(), s * n.x() + c * n.y()).cast<float>()});
        }
    }
    return one;
}

/// Of the position along the direction that is held least, whatever the heading.
double sigma_of_weakest_m(const Eigen::Matrix3d& information) {
    const Eigen::Vector2d with_heading = information.block<2, 1>(0, 2);
    const Eigen::Matrix2d position =
        information.topLeftCorner<2, 2>() -
        with_heading * with_heading.transpose() / std::max(information(2, 2), 1e-12);
    const double mean = position.trace() / 2,
                 half = std::hypot((position(0, 0) - position(1, 1)) / 2, position(0, 1));
    return 1 / std::sqrt(std::max(mean - half, 1e-12));
}

/// Distance of the returns, but for the farthest tenth.
double reach_of(const std::vector<Eigen::Vector2f>& points) {
    std::vector<float> ranges_m;
    for (const auto& p : points) ranges_m.push_back(p.norm());
    if (ranges_m.empty()) return 1;
    const auto at = ranges_m.begin() + static_cast<std::ptrdiff_t>(ranges_m.size() * 9 / 10);
    std::nth_element(ranges_m.begin(), at, ranges_m.end());
    return std::max(1.0, static_cast<double>(*at));
}

}  // namespace

grid_map::SearchWindow StartSearch::window(const FrozenMap& map, const StartRegion& region,
                                           double reach_m) const {
    constexpr double sigmas = 3;
    const double cell_m = map.coarse_grid().cell_m();
    grid_map::SearchWindow window;
    Eigen::Vector2d lower_m = map.lower_m(), upper_m = map.upper_m();
    double turn_rad = M_PI, phi_rad = 0;
    if (!region.whole_map) {
        const Eigen::Vector2d around_m =
            (sigmas * region.covariance.diagonal().head<2>().cwiseSqrt()).array() + 2 * cell_m;
        lower_m = lower_m.cwiseMax(region.T_map_base.translation() - around_m);
        upper_m = upper_m.cwiseMin(region.T_map_base.translation() + around_m);
        upper_m = upper_m.cwiseMax(lower_m);
        turn_rad = std::min(M_PI, sigmas * std::sqrt(region.covariance(2, 2)) + 2 * M_PI / 180);
        phi_rad = region.T_map_base.phi_rad;
    }
    const Eigen::Vector2d middle_m = 0.5 * (lower_m + upper_m);
    window.T_map_center = {middle_m.x(), middle_m.y(), phi_rad};
    window.cells_x = static_cast<int>(std::ceil((upper_m.x() - middle_m.x()) / cell_m));
    window.cells_y = static_cast<int>(std::ceil((upper_m.y() - middle_m.y()) / cell_m));
    // A return at the reach moves by no more than a cell from one heading to the next.
    const double step_rad = std::clamp(cell_m / reach_m, 0.3 * M_PI / 180, 3 * M_PI / 180);
    window.headings = static_cast<int>(std::ceil(turn_rad / step_rad));
    window.heading_step_rad = turn_rad / window.headings;
    for (int dy = -window.cells_y; dy <= window.cells_y; ++dy)
        for (int dx = -window.cells_x; dx <= window.cells_x; ++dx)
            window.allowed.push_back(map.may_stand(middle_m + cell_m * Eigen::Vector2d(dx, dy)) ? 1 : 0);
    return window;
}

/// On the fine grid, around a place of the coarse one.
std::optional<StartSearch::Place> StartSearch::sharpened(const FrozenMap& map,
                                                         const std::vector<Eigen::Vector2f>& points,
                                                         const grid_map::SearchResult& coarse) const {
    grid_map::SearchWindow around;
    around.T_map_center = coarse.T_map_base;
    around.cells_x = around.cells_y =
        static_cast<int>(std::ceil(2 * map.coarse_grid().cell_m() / map.grid().cell_m()));
    around.heading_step_rad = 0.3 * M_PI / 180;
    around.headings = 8;
    const auto found = grid_map::branch_and_bound(map.grid(), points, around);
    if (!found) return std::nullopt;
    return Place{found->T_map_base, found->fit};
}

/// The best place, unless another one is nearly as good. `latest_` says why not.
std::optional<StartSearch::Place> StartSearch::best_place(const FrozenMap& map,
                                                          const std::vector<Eigen::Vector2f>& points,
                                                          grid_map::SearchWindow window) {
    // A place fits coarse cells at least about as well as fine ones.
    constexpr double margin = 0.02;
    constexpr int most_places = 6;
    const double full = grid_map::ScanGrid::full_likelihood * static_cast<double>(points.size());
    const double coarse_m = map.coarse_grid().cell_m();
    std::optional<Place> best;
    int best_coarse = 0;
    for (int tried = 0; tried < most_places; ++tried) {
        window.min_score = static_cast<int>(
            std::max((settings_.rival - margin) * best_coarse, (settings_.min_likelihood - margin) * full));
        const auto coarse = grid_map::branch_and_bound(map.coarse_grid(), points, window);
        if (!coarse) {
            if (!best) latest_.reason = "no place of the map fits the scans";
            return best;
        }
        best_coarse = std::max(best_coarse, coarse->score);
        const auto place = sharpened(map, points, *coarse);
        if (place && best) {
            const bool better = place->likelihood > best->likelihood;
            latest_.rival = better ? best->likelihood : std::max(latest_.rival, place->likelihood);
            if (better) best = place;
            latest_.likelihood = best->likelihood;
            latest_.T_map_base = best->T_map_base;
            if (latest_.rival >= settings_.rival * best->likelihood) {
                latest_.reason = "another place of the map fits as well";
                latest_.ambiguous = true;
                return std::nullopt;
            }
        } else if (place) {
            best = place;
            latest_.likelihood = best->likelihood;
            latest_.T_map_base = best->T_map_base;
        }
        grid_map::SearchWindow::Exclusion known{
            coarse->dx_cells, coarse->dy_cells, coarse->heading,
            static_cast<int>(std::ceil(settings_.rival_m / coarse_m)),
            static_cast<int>(std::ceil(settings_.rival_rad / window.heading_step_rad))};
        // Headings of a full turn go on at its beginning.
        const int turn = static_cast<int>(std::lround(2 * M_PI / window.heading_step_rad));
        for (const int turns : {-1, 0, 1}) {
            known.heading = coarse->heading + turns * turn;
            window.also_without.push_back(known);
        }
    }
    latest_.reason = "too many places of the map fit the scans";
    latest_.ambiguous = true;
    return std::nullopt;
}

bool StartSearch::agrees(const Sighting& sighting) const {
    return std::any_of(sightings_.begin(), sightings_.end(), [&](const Sighting& other) {
        const double way_m = sighting.way_m - other.way_m;
        if (way_m < settings_.agree_after_m || way_m > settings_.agree_within_m) return false;
        const Pose2 by_motion = other.T_local_base.inverse() * sighting.T_local_base,
                    by_map = other.T_map_base.inverse() * sighting.T_map_base,
                    apart = by_motion.inverse() * by_map;
        return apart.translation().norm() < settings_.agree_m + 0.02 * way_m &&
               std::abs(apart.phi_rad) < settings_.agree_rad;
    });
}

std::optional<StartFound> StartSearch::look(const FrozenMap& map, const MapFrames& frames, double way_m,
                                            const StartRegion& region) {
    if (frames.size() == 0 || way_m - looked_at_m_ < settings_.every_m) return std::nullopt;
    looked_at_m_ = way_m;
    ++looks_;
    auto sighting = sight(map, frames, settings_.latest_m, region);
    // More of the way tells places apart that look alike here, but is less well known in itself.
    if (!sighting && latest_.ambiguous && frames.path_m[frames.last()] > settings_.latest_m)
        sighting = sight(map, frames, settings_.long_m, region);
    if (!sighting) return std::nullopt;
    sighting->way_m = way_m;
    const bool certain = agrees(*sighting);
    sightings_.push_back(*sighting);
    latest_.reason = certain ? "two looks agree" : "a second look must agree after some way";
    if (!certain) return std::nullopt;
    StartFound found;
    found.T_map_base = sighting->T_map_base;
    found.information = sighting->information;
    found.covariance = (sighting->information + 1e-6 * Eigen::Matrix3d::Identity()).inverse();
    found.fit = latest_.fit;
    return found;
}

/// The place by one look; `latest_` says why not.
std::optional<StartSearch::Sighting> StartSearch::sight(const FrozenMap& map, const MapFrames& frames,
                                                        double latest_m, const StartRegion& region) {
    latest_ = {};
    const grid_map::Frame latest = latest_frames_as_one(frames, latest_m);
    const auto points = grid_map::search_points(latest, static_cast<std::size_t>(settings_.search_points));
    if (points.empty()) {
        latest_.reason = "the scans have no returns";
        return std::nullopt;
    }
    const auto place = best_place(map, points, window(map, region, reach_of(points)));
    if (!place) return std::nullopt;
    if (place->likelihood < settings_.min_likelihood) {
        latest_.reason = "no place of the map fits the scans well";
        return std::nullopt;
    }
    const auto fit = grid_map::refine(map.surfaces(), latest, place->T_map_base, place->T_map_base,
                                      Eigen::Matrix3d::Zero(), settings_.refinement);
    latest_.fit = fit.fit;
    latest_.T_map_base = fit.T_map_base;
    const Eigen::Matrix3d information = settings_.information_share * fit.information;
    if (fit.fit < settings_.min_fit) {
        latest_.reason = "too few returns lie on surfaces of the map";
        return std::nullopt;
    }
    if (!(sigma_of_weakest_m(information) < settings_.max_sigma_m)) {
        latest_.reason = "the scans don't hold the pose in all directions";
        return std::nullopt;
    }
    return Sighting{0, frames.poses[frames.last()], fit.T_map_base, information};
}

}  // namespace loopline::grid_slam
