#include "simulation/town/terrain.h"

#include <algorithm>
#include <cmath>

namespace loopline::simulation {
namespace {

constexpr WaveBand hill_waves{80, 400}, rough_waves{4, 30};

/// From 0 to 1 without a jump of slope or curvature.
double smooth_step(double u) {
    u = std::clamp(u, 0.0, 1.0);
    return u * u * u * (10 + u * (6 * u - 15));
}
double smooth_step_slope(double u) {
    u = std::clamp(u, 0.0, 1.0);
    return 30 * u * u * (1 - u) * (1 - u);
}

}  // namespace

Terrain::Terrain(const TerrainSettings& settings, const Pose2& T_map_world, std::uint64_t seed)
    : hills_(settings.sigma_slope_rad, seed, hill_waves, "hills"),
      roughness_(settings.sigma_rough_rad, seed, rough_waves, "roughness") {
    for (const auto& row : settings.ramps) {
        const Eigen::Vector2d foot_m = T_map_world * Eigen::Vector2d(row[0], row[1]),
                              way_m = T_map_world * Eigen::Vector2d(row[2], row[3]) - foot_m;
        ramps_.push_back({foot_m, way_m.normalized(), way_m.norm(), row[4]});
        origin_m_ += row[4] * smooth_step(ramps_.back().part_at({0, 0}));
    }
}

double Terrain::height_m(const Eigen::Vector2d& place_m) const {
    double sum_m = hills_.height_m(place_m) + roughness_.height_m(place_m) - origin_m_;
    for (const Ramp& ramp : ramps_) sum_m += ramp.rise_m * smooth_step(ramp.part_at(place_m));
    return sum_m;
}

Eigen::Vector2d Terrain::slope(const Eigen::Vector2d& place_m) const {
    Eigen::Vector2d sum = hills_.slope(place_m) + roughness_.slope(place_m);
    for (const Ramp& ramp : ramps_)
        sum += ramp.rise_m / ramp.length_m * smooth_step_slope(ramp.part_at(place_m)) * ramp.ahead;
    return sum;
}

}  // namespace loopline::simulation
