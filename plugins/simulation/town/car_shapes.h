/// Cars and vans, parked or moving.
#pragma once

#include "api/pose3.h"
#include "simulation/mesh/triangle_mesh.h"
#include "simulation/random_stream.h"

namespace loopline::simulation {

struct CarShape {
    double length_m = 4.3, width_m = 1.8, height_m = 1.5;
    bool van = false;
    Material paint = Material::paint;
};
CarShape draw_car(RandomStream& random);

/// `T_mesh_car`: the middle of the car on the ground, x ahead.
void add_car(TriangleMesh& mesh, const Pose3& T_mesh_car, const CarShape& shape);

}  // namespace loopline::simulation
