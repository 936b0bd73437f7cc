/// Houses with windows set back in their walls, pilasters, balconies and a cornice.
#pragma once

#include "simulation/mesh/solids.h"
#include "simulation/random_stream.h"

namespace loopline::simulation {

/// On ground between `lowest_m` and `highest_m`, where its first floor begins.
void add_building(TriangleMesh& mesh, const Footprint& footprint, double lowest_m, double highest_m,
                  int storeys, RandomStream& random);

}  // namespace loopline::simulation
