/// Keys of matching with the surfaces of a map, which mapping and localisation share.
#pragma once

#include "api/parameters.h"
#include "lidar_mapping/sweep_mapping.h"

namespace loopline::lidar_mapping {

/// Which returns of a sweep are looked at.
void declare_range(ParameterTable& table, SamplingSettings& sampling);
/// The map's cubes, how returns are matched with them, and how the vehicle moves.
void declare_surfaces(ParameterTable& table, SurfaceMapSettings& map);
void declare_registration(ParameterTable& table, SweepMappingSettings& settings);

}  // namespace loopline::lidar_mapping
