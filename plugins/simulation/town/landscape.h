/// All that a vehicle outdoors drives on, past and among.
#pragma once

#include <memory>

#include "simulation/town/terrain.h"
#include "simulation/town/town.h"
#include "simulation/town/traffic.h"

namespace loopline::simulation {

/// Stays where it is: traffic knows the street and the ground.
struct Landscape {
    Landscape() = default;
    Landscape(const Landscape&) = delete;
    Landscape& operator=(const Landscape&) = delete;

    Street driven;
    std::unique_ptr<Ground> ground;
    Town town;
    Traffic traffic;
};

}  // namespace loopline::simulation
