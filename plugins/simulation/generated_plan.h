/// A world that was drawn by a seed, with a route through it.
#pragma once

#include <vector>

#include "simulation/walkers.h"
#include "simulation/world.h"

namespace loopline::simulation {

struct GeneratedPlan {
    World world;
    Waypoints route;
    std::vector<Walker> walkers;
};

}  // namespace loopline::simulation
