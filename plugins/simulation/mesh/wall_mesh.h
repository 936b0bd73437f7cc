/// A plan of upright walls as triangles.
#pragma once

#include "simulation/mesh/triangle_mesh.h"
#include "simulation/world.h"

namespace loopline::simulation {

/// With ground, and a ceiling if there is one, as far as walls reach and a lidar's range beyond.
TriangleMesh mesh_of(const World& world);

}  // namespace loopline::simulation
