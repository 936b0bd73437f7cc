#include "simulation/town/car_shapes.h"

namespace loopline::simulation {
namespace {

/// A level rectangle: from behind to ahead, and half its width.
struct Slice {
    double behind_m, ahead_m, half_m, z_m;
};

/// Between two slices, closed above.
void add_hull(TriangleMesh& mesh, const Pose3& T_mesh_car, const Slice& low, const Slice& high,
              Material sides, Material top) {
    const auto corner_m = [&](const Slice& s, int i) -> Eigen::Vector3d {
        return T_mesh_car * Eigen::Vector3d(i == 0 || i == 3 ? s.ahead_m : s.behind_m,
                                            i < 2 ? s.half_m : -s.half_m, s.z_m);
    };
    for (int i = 0; i < 4; ++i)
        mesh.add_quad(corner_m(low, i), corner_m(low, (i + 1) % 4), corner_m(high, (i + 1) % 4),
                      corner_m(high, i), sides);
    mesh.add_quad(corner_m(high, 0), corner_m(high, 1), corner_m(high, 2), corner_m(high, 3), top);
}

}  // namespace

CarShape draw_car(RandomStream& random) {
    CarShape shape;
    shape.van = random.chance(0.15);
    shape.length_m = shape.van ? random.uniform(4.8, 6) : random.uniform(3.7, 4.8);
    shape.width_m = shape.van ? random.uniform(1.9, 2.05) : random.uniform(1.65, 1.85);
    shape.height_m = shape.van ? random.uniform(2, 2.5) : random.uniform(1.4, 1.6);
    shape.paint = random.chance(0.3) ? Material::asphalt : Material::paint;  // black, or not
    return shape;
}

void add_car(TriangleMesh& mesh, const Pose3& T_mesh_car, const CarShape& shape) {
    const double l = shape.length_m / 2, w = shape.width_m / 2, h = shape.height_m;
    constexpr double clearance_m = 0.2;
    if (shape.van) {
        add_hull(mesh, T_mesh_car, {-l, l, w, clearance_m}, {-l, l, w, 1}, shape.paint, shape.paint);
        add_hull(mesh, T_mesh_car, {-l, l, w, 1}, {-l, l - 0.8, w - 0.1, h}, shape.paint, shape.paint);
        return;
    }
    const double waist_m = 0.6 * h;
    add_hull(mesh, T_mesh_car, {-l, l, w, clearance_m}, {-l, l, w, waist_m}, shape.paint, shape.paint);
    add_hull(mesh, T_mesh_car, {-0.85 * l, 0.45 * l, w - 0.05, waist_m}, {-0.6 * l, 0.05 * l, w - 0.25, h},
             Material::glass, shape.paint);
}

}  // namespace loopline::simulation
