#include "simulation/town/street.h"

#include <algorithm>
#include <cmath>

#include "simulation/town/plan_cell.h"

namespace loopline::simulation {
namespace {

constexpr double sample_m = 0.5;  ///< from point to point of a street in the index
constexpr double heading_base_m = 4;

}  // namespace

Street::Street(const std::vector<Eigen::Vector2d>& points_m) {
    for (const Eigen::Vector2d& p : points_m) {
        const double step_m = points_m_.empty() ? 0 : (p - points_m_.back()).norm();
        if (!points_m_.empty() && step_m < 1e-6) continue;
        ways_m_.push_back(points_m_.empty() ? 0 : ways_m_.back() + step_m);
        points_m_.push_back(p);
    }
}

Eigen::Vector2d Street::place_m(double way_m) const {
    const auto after = std::upper_bound(ways_m_.begin() + 1, ways_m_.end() - 1, way_m);
    const auto i = static_cast<std::size_t>(after - ways_m_.begin());
    const double part = (way_m - ways_m_[i - 1]) / (ways_m_[i] - ways_m_[i - 1]);
    return points_m_[i - 1] + part * (points_m_[i] - points_m_[i - 1]);
}

Pose2 Street::at(double way_m) const {
    const Eigen::Vector2d here_m = place_m(way_m);
    const Eigen::Vector2d ahead = place_m(way_m + heading_base_m / 2) - place_m(way_m - heading_base_m / 2);
    return {here_m.x(), here_m.y(), std::atan2(ahead.y(), ahead.x())};
}

void StreetIndex::add(const Street& street) {
    for (double way_m = 0; way_m < street.length_m() + sample_m; way_m += sample_m) {
        const Eigen::Vector2d p = street.at(std::min(way_m, street.length_m())).translation();
        points_of_cell_[cell_key(cell_of(p.x(), cell_m), cell_of(p.y(), cell_m))].push_back(p);
    }
}

template <class Visit>
void StreetIndex::visit_near(const Eigen::Vector2d& place_m, double reach_m, const Visit& visit) const {
    for (auto x = cell_of(place_m.x() - reach_m, cell_m); x <= cell_of(place_m.x() + reach_m, cell_m); ++x)
        for (auto y = cell_of(place_m.y() - reach_m, cell_m); y <= cell_of(place_m.y() + reach_m, cell_m);
             ++y)
            if (const auto found = points_of_cell_.find(cell_key(x, y)); found != points_of_cell_.end())
                for (const Eigen::Vector2d& p : found->second) visit(p);
}

double StreetIndex::distance_m(const Eigen::Vector2d& place_m, double most_m) const {
    double least_m2 = most_m * most_m;
    visit_near(place_m, most_m,
               [&](const Eigen::Vector2d& p) { least_m2 = std::min(least_m2, (p - place_m).squaredNorm()); });
    return std::sqrt(least_m2);
}

bool StreetIndex::is_clear(const Footprint& footprint, double clearance_m) const {
    bool clear = true;
    visit_near(footprint.T_map_middle.translation(), footprint.reach_m() + clearance_m,
               [&](const Eigen::Vector2d& p) {
                   clear = clear && loopline::simulation::distance_m(footprint, p) >= clearance_m;
               });
    return clear;
}

template <class Visit>
void Lots::visit_cells(const Footprint& footprint, const Visit& visit) {
    const Eigen::Vector2d middle_m = footprint.T_map_middle.translation();
    const double reach_m = footprint.reach_m();
    for (auto x = cell_of(middle_m.x() - reach_m, cell_m); x <= cell_of(middle_m.x() + reach_m, cell_m); ++x)
        for (auto y = cell_of(middle_m.y() - reach_m, cell_m); y <= cell_of(middle_m.y() + reach_m, cell_m);
             ++y)
            visit(cell_key(x, y));
}

bool Lots::is_free(const Footprint& footprint) const {
    bool free = true;
    visit_cells(footprint, [&](std::int64_t key) {
        const auto found = of_cell_.find(key);
        if (found == of_cell_.end()) return;
        for (const std::size_t i : found->second) free = free && !overlap(taken_[i], footprint);
    });
    return free;
}

void Lots::take(const Footprint& footprint) {
    visit_cells(footprint, [&](std::int64_t key) { of_cell_[key].push_back(taken_.size()); });
    taken_.push_back(footprint);
}

}  // namespace loopline::simulation
