/// Streets between rows of buildings with stepped fronts: a world of thousands of walls, no two on one line,
/// and a long drive to and fro past all of them.
#pragma once

#include <cstdint>

#include "simulation/generated_plan.h"

namespace loopline::simulation {

struct CampusSettings {
    int walls = 3000;  ///< at least
    int columns = 15;  ///< buildings along a street
    double street_m = 10;
    double gap_m = 5;  ///< between neighbours along a street
    double building_length_m = 24;
    double building_depth_m = 14;
    int sections = 5;                    ///< of a front, each set back by itself
    double step_m = 2;                   ///< by so much at most
    double turned_rad = 6 * M_PI / 180;  ///< buildings stand askew by so much at most
    double height_m = 6;
};

GeneratedPlan make_campus(const CampusSettings& settings, std::uint64_t seed);

}  // namespace loopline::simulation
