#include "lidar_mapping/matching_parameters.h"

namespace loopline::lidar_mapping {

void declare_range(ParameterTable& table, SamplingSettings& sampling) {
    table.real("min_range_m", sampling.min_range_m, {0, 100}, "Nearer returns are of the vehicle itself.")
        .real("max_range_m", sampling.max_range_m, {1, 1000}, "Farther returns are left out.");
}

void declare_surfaces(ParameterTable& table, SurfaceMapSettings& map) {
    table
        .real("cell_m", map.cell_m, {0.05, 10},
              "Edge of the map's smallest cubes, each with one plane or edge.")
        .integer("sizes", map.sizes, {1, 5}, "Sizes of cubes, each twice as large as the one before.");
}

void declare_registration(ParameterTable& table, SweepMappingSettings& s) {
    table.real("sigma_range_m", s.map.sigma_range_m, {1e-3, 1}, "Standard deviation of a range.")
        .real("loss_scale", s.registration.loss_scale, {0.1, 100},
              "A return that is so many standard deviations off its surface counts half.")
        .real("sigma_degenerate_m", s.registration.sigma_degenerate_m, {1e-3, 10},
              "A direction of motion that a sweep holds no better than this is not observed.")
        .real("sigma_acceleration_mps2", s.motion.sigma_acceleration_mps2, {0.01, 100},
              "How quickly the vehicle's speed changes.")
        .real("sigma_turn_radps2", s.motion.sigma_turn_radps2, {0.01, 100}, "And its rates of turn.");
}

}  // namespace loopline::lidar_mapping
