/// The ground of a landscape that is drawn: hills, roughness, and ramps.
#pragma once

#include <vector>

#include "simulation/uneven_floor.h"

namespace loopline::simulation {

struct TerrainSettings {
    double sigma_slope_rad = 0;              ///< of hills
    double sigma_rough_rad = 0;              ///< of what is shorter
    std::vector<std::vector<double>> ramps;  ///< x1 y1 x2 y2 rise
};

class Terrain : public Ground {
 public:
    /// In the map frame, where the height of the origin is 0. `T_map_world` maps the ramps' ends.
    Terrain(const TerrainSettings& settings, const Pose2& T_map_world, std::uint64_t seed);

    double height_m(const Eigen::Vector2d& place_m) const override;
    Eigen::Vector2d slope(const Eigen::Vector2d& place_m) const override;

 private:
    /// Rises along the line from its foot to its top, the same across; level before and after.
    struct Ramp {
        Eigen::Vector2d foot_m, ahead;
        double length_m, rise_m;
        double part_at(const Eigen::Vector2d& place_m) const {
            return (place_m - foot_m).dot(ahead) / length_m;
        }
    };
    UnevenFloor hills_, roughness_;
    std::vector<Ramp> ramps_;
    double origin_m_ = 0;
};

}  // namespace loopline::simulation
