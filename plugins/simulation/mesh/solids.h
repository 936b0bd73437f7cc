/// Solids as triangles: boxes, posts and blobs.
#pragma once

#include "api/pose2.h"
#include "simulation/mesh/triangle_mesh.h"

namespace loopline::simulation {

/// A rectangle on the plan.
struct Footprint {
    Pose2 T_map_middle;
    double length_m = 0, width_m = 0;  ///< along its x and y axis

    Eigen::Vector2d corner_m(double x_sign, double y_sign) const {
        return T_map_middle * Eigen::Vector2d(x_sign * length_m / 2, y_sign * width_m / 2);
    }
    double reach_m() const { return std::hypot(length_m, width_m) / 2; }
};
bool overlap(const Footprint& a, const Footprint& b);
/// 0 within.
double distance_m(const Footprint& footprint, const Eigen::Vector2d& place_m);

/// Four sides and a top; the material of the top is that of the sides.
void add_block(TriangleMesh& mesh, const Footprint& footprint, double bottom_m, double top_m,
               Material material);

/// An upright prism of `sides` sides about a circle, which tapers from one radius to the other, closed above.
void add_post(TriangleMesh& mesh, const Eigen::Vector2d& middle_m, double bottom_m, double top_m,
              double radius_m, double top_radius_m, int sides, Material material);

/// An ellipsoid of triangles whose corners lie up to `roughness` of the radius inside; `phase` tells one from
/// another.
void add_blob(TriangleMesh& mesh, const Eigen::Vector3d& middle_m, double radius_m, double half_height_m,
              double roughness, double phase, Material material);

}  // namespace loopline::simulation
