#include "cloud_localisation/start_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "cloud_localisation/sweep_from_above.h"

namespace loopline::cloud_localisation {
namespace {

using lidar_mapping::MotionState;
using lidar_mapping::Registration;
using lidar_mapping::SweepPoint;
using lidar_mapping::Vector12d;

// Of a place that was found from above, before it is matched in space.
constexpr double sigma_place_m = 0.7, sigma_height_m = 0.3, sigma_turn_rad = 2 * M_PI / 180;
constexpr double sigma_velocity_mps = 0.5, sigma_rate_radps = 0.1;
/// In the place of the best, others this near are the same.
constexpr double apart_m = 1.5, apart_rad = 8 * M_PI / 180;
/// A height that is known is believed against the ground's if that is farther off.
constexpr double height_gate_sigmas = 4, height_gate_m = 1;

std::string decimals(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

struct Grid {
    int steps = 0;  ///< of places, to both sides
    double first_rad = 0, step_rad = 0;
    int headings = 0;

    std::size_t per_heading() const {
        return static_cast<std::size_t>(2 * steps + 1) * static_cast<std::size_t>(2 * steps + 1);
    }
    double heading_rad(std::size_t k) const { return first_rad + static_cast<double>(k) * step_rad; }
};

Grid grid_of(const StartRegion& region, const StartSettings& settings) {
    Grid grid;
    const double window_m = std::min(settings.max_window_m, settings.window_sigmas * region.sigma_m);
    grid.steps = static_cast<int>(std::ceil(window_m / settings.step_m)) + 1;
    const double half_rad = settings.window_sigmas * region.sigma_yaw_rad + settings.step_rad;
    const bool all = half_rad >= M_PI;
    const double span_rad = all ? 2 * M_PI : 2 * half_rad;
    grid.headings = static_cast<int>(std::ceil(span_rad / settings.step_rad));
    grid.step_rad = span_rad / grid.headings;
    grid.first_rad = all ? -M_PI : region.yaw_rad - half_rad;
    grid.headings += all ? 0 : 1;
    return grid;
}

/// Where the vehicle is if it heads so, and the point of the region is in its middle.
Eigen::Vector2d middle_m(const StartRegion& region, double heading_rad) {
    return region.p_map_m.head<2>() -
           Eigen::Rotation2Dd(heading_rad) * Eigen::Vector2d(region.p_base_m.head<2>());
}

/// Of each place in the order of headings, then y, then x: sum of the field over the columns.
std::vector<std::int32_t> scores_of(const UprightField& field, const std::vector<Eigen::Vector2f>& columns,
                                    const StartRegion& region, const Grid& grid, double step_m,
                                    WorkerPool& workers) {
    std::vector<std::int32_t> scores(grid.per_heading() * static_cast<std::size_t>(grid.headings), 0);
    workers.run(static_cast<std::size_t>(grid.headings), [&](std::size_t k) {
        const double heading_rad = grid.heading_rad(k);
        const Eigen::Matrix2f R = Eigen::Rotation2Dd(heading_rad).toRotationMatrix().cast<float>();
        const Eigen::Vector2d middle = middle_m(region, heading_rad);
        std::int32_t* score = scores.data() + k * grid.per_heading();
        std::vector<Eigen::Vector2f> turned;
        for (const auto& p : columns) turned.push_back(R * p);
        for (int y = -grid.steps; y <= grid.steps; ++y)
            for (int x = -grid.steps; x <= grid.steps; ++x, ++score) {
                const auto x_m = static_cast<float>(middle.x() + x * step_m),
                           y_m = static_cast<float>(middle.y() + y * step_m);
                for (const auto& p : turned) *score += field.at(x_m + p.x(), y_m + p.y());
            }
    });
    return scores;
}

/// The best place, then the best that is no neighbour of it, and so on.
std::vector<Pose2> best_places(std::vector<std::int32_t> scores, const StartRegion& region, const Grid& grid,
                               const StartSettings& settings) {
    std::vector<Pose2> places;
    const int side = 2 * grid.steps + 1, near = static_cast<int>(apart_m / settings.step_m),
              near_turns = static_cast<int>(apart_rad / grid.step_rad);
    const bool all_around = !std::isfinite(region.sigma_yaw_rad);
    while (static_cast<int>(places.size()) < settings.places) {
        const auto best = std::max_element(scores.begin(), scores.end());
        if (*best <= 0) break;
        const auto index = static_cast<std::size_t>(best - scores.begin());
        const std::size_t k = index / grid.per_heading();
        const int cell = static_cast<int>(index % grid.per_heading()), x = cell % side - grid.steps,
                  y = cell / side - grid.steps;
        const double heading_rad = grid.heading_rad(k);
        const Eigen::Vector2d at_m = middle_m(region, heading_rad) + settings.step_m * Eigen::Vector2d(x, y);
        places.push_back({at_m.x(), at_m.y(), heading_rad});
        for (int turn = -near_turns; turn <= near_turns; ++turn) {
            int other = static_cast<int>(k) + turn;
            if (all_around) other = (other + grid.headings) % grid.headings;
            if (other < 0 || other >= grid.headings) continue;
            for (int dy = std::max(-grid.steps, y - near); dy <= std::min(grid.steps, y + near); ++dy)
                for (int dx = std::max(-grid.steps, x - near); dx <= std::min(grid.steps, x + near); ++dx)
                    scores[static_cast<std::size_t>(other) * grid.per_heading() +
                           static_cast<std::size_t>((dy + grid.steps) * side + dx + grid.steps)] = 0;
        }
    }
    return places;
}

struct Matched {
    Registration registration;
    double fit = 0;
};

/// Put on the ground, or at the height that is known, and matched with large cubes, then with all.
std::optional<Matched> matched_at(const FrozenCloud& map, const Pose2& T_map_base, const SweepFromAbove& seen,
                                  const std::vector<SweepPoint>& matched, const Twist3& velocity,
                                  const StartRegion& region, const StartSettings& settings,
                                  WorkerPool& workers) {
    auto placed = on_ground(map.columns(), seen.lowest_base_m, T_map_base);
    if (std::isfinite(region.sigma_z_m)) {
        const double known_m = region.p_map_m.z() - region.p_base_m.z();
        if (!placed || std::abs(placed->translation_m.z() - known_m) >
                           height_gate_sigmas * region.sigma_z_m + height_gate_m) {
            placed = Pose3(T_map_base);
            placed->translation_m.z() = known_m;
        }
    }
    if (!placed) return std::nullopt;
    MotionState predicted;
    predicted.T_map_base = *placed;
    predicted.velocity = velocity;
    Vector12d sigma;
    sigma << sigma_place_m, sigma_place_m, sigma_height_m, Eigen::Vector3d::Constant(sigma_turn_rad),
        Eigen::Vector3d::Constant(sigma_velocity_mps), Eigen::Vector3d::Constant(sigma_rate_radps);
    predicted.covariance = sigma.cwiseAbs2().asDiagonal();
    auto coarse = settings.registration;
    coarse.smallest_size = map.surfaces().sizes() / 2;
    const Registration drawn_in = register_sweep(map.surfaces(), matched, predicted, coarse, workers);
    Matched result;
    result.registration =
        register_sweep(map.surfaces(), matched, predicted, settings.registration, workers, &drawn_in.state);
    result.fit = fit_in_map(map, seen.standing, result.registration.state);
    return result;
}

bool is_another(const MotionState& a, const MotionState& b, const StartSettings& settings) {
    const Pose3 between = a.T_map_base.inverse() * b.T_map_base;
    return between.translation_m.norm() > settings.rival_m ||
           a.T_map_base.rotation.angularDistance(b.T_map_base.rotation) > settings.rival_rad;
}

/// A place that matching has moved out of the region is none of it.
bool is_within(const StartRegion& region, const MotionState& state, const StartSettings& settings) {
    const Eigen::Vector2d off_m = (state.T_map_base * region.p_base_m - region.p_map_m).head<2>();
    if (off_m.norm() > settings.window_sigmas * region.sigma_m + settings.step_m) return false;
    const double turn_rad = std::remainder(state.T_map_base.yaw_rad() - region.yaw_rad, 2 * M_PI);
    return !std::isfinite(region.sigma_yaw_rad) ||
           std::abs(turn_rad) < (settings.window_sigmas + 1) * region.sigma_yaw_rad + settings.rival_rad;
}

template <class T>
std::vector<T> spread_over(const std::vector<T>& all, std::size_t count) {
    std::vector<T> some;
    for (std::size_t i = 0; i < std::min(count, all.size()); ++i)
        some.push_back(all[i * all.size() / std::min(count, all.size())]);
    return some;
}

StartLook not_found(const std::string& reason) {
    StartLook look;
    look.reason = reason;
    return look;
}

}  // namespace

double fit_in_map(const FrozenCloud& map, const std::vector<SweepPoint>& points, const MotionState& state) {
    const lidar_mapping::SweepMotion motion(state);
    std::size_t near = 0;
    for (const SweepPoint& point : points)
        near += map.surfaces().has_return_near(state.T_map_base * lidar_mapping::undistorted(point, motion))
                    ? 1
                    : 0;
    return points.empty() ? 0 : static_cast<double>(near) / static_cast<double>(points.size());
}

StartLook look_for_start(const FrozenCloud& map, const std::vector<SweepPoint>& points,
                         const std::vector<SweepPoint>& matched, const Twist3& velocity,
                         const StartRegion& region, const StartSettings& settings, WorkerPool& workers) {
    if (settings.window_sigmas * region.sigma_m > settings.max_window_m)
        return not_found("the place is known to " + decimals(region.sigma_m, 0) + " m only");
    if (const double off_m = map.distance_m(region.p_map_m); off_m > settings.range_m)
        return not_found("it should be " + decimals(off_m, 0) + " m outside of the map");
    const SweepFromAbove seen = seen_from_above(points, velocity, settings.range_m);
    if (static_cast<int>(seen.upright_base_m.size()) < settings.min_columns)
        return not_found("too little stands upright around the vehicle");
    const Grid grid = grid_of(region, settings);
    const double radius_m =
        settings.range_m + grid.steps * settings.step_m * M_SQRT2 + region.p_base_m.head<2>().norm();
    const UprightField field(map.columns(), region.p_map_m.head<2>(), radius_m);
    if (field.upright() < settings.min_columns)
        return not_found("too little of the map stands upright there");
    const auto columns = spread_over(seen.upright_base_m, static_cast<std::size_t>(settings.columns));
    const auto places = best_places(scores_of(field, columns, region, grid, settings.step_m, workers), region,
                                    grid, settings);

    StartLook look;
    Registration best;
    std::vector<Matched> all;
    for (const Pose2& place : places) {
        auto found = matched_at(map, place, seen, matched, velocity, region, settings, workers);
        if (!found || !is_within(region, found->registration.state, settings)) continue;
        if (found->fit > look.fit) {
            look.fit = found->fit;
            best = found->registration;
        }
        all.push_back(std::move(*found));
    }
    look.state = best.state;
    for (const Matched& other : all)
        if (is_another(other.registration.state, best.state, settings))
            look.rival_fit = std::max(look.rival_fit, other.fit);
    if (look.fit < settings.min_fit)
        look.reason = "no place there fits";
    else if (look.rival_fit > settings.rival * look.fit)
        look.reason = "several places fit";
    else if (best.degeneracy.free_directions > 0)
        look.reason = "the surroundings leave a direction free";
    else if (!best.converged)
        look.reason = "the sweep does not settle in the map";
    else
        look.found = true;
    if (look.found) look.reason.clear();
    return look;
}

}  // namespace loopline::cloud_localisation
