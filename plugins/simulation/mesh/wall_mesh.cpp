#include "simulation/mesh/wall_mesh.h"

#include <cmath>

namespace loopline::simulation {

TriangleMesh mesh_of(const World& world) {
    constexpr double beyond_m = 150;
    TriangleMesh mesh;
    Eigen::Vector2d least_m(0, 0), most_m(0, 0);
    for (const Wall& wall : world.walls) {
        const auto at = [](const Eigen::Vector2d& p, double z_m) {
            return Eigen::Vector3d(p.x(), p.y(), z_m);
        };
        mesh.add_quad(at(wall.from_m, wall.bottom_m), at(wall.to_m, wall.bottom_m), at(wall.to_m, wall.top_m),
                      at(wall.from_m, wall.top_m), Material::plaster);
        for (const Eigen::Vector2d& p : {wall.from_m, wall.to_m}) {
            least_m = least_m.cwiseMin(p);
            most_m = most_m.cwiseMax(p);
        }
    }
    least_m.array() -= beyond_m;
    most_m.array() += beyond_m;
    const auto add_level = [&](double z_m, Material material) {
        mesh.add_quad({least_m.x(), least_m.y(), z_m}, {most_m.x(), least_m.y(), z_m},
                      {most_m.x(), most_m.y(), z_m}, {least_m.x(), most_m.y(), z_m}, material);
    };
    add_level(world.ground_m, Material::pavement);
    if (std::isfinite(world.ceiling_m)) add_level(world.ceiling_m, Material::plaster);
    return mesh;
}

}  // namespace loopline::simulation
