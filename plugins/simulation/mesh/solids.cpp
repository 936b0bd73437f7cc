#include "simulation/mesh/solids.h"

#include <algorithm>
#include <cmath>

namespace loopline::simulation {
namespace {

Eigen::Vector3d at_height(const Eigen::Vector2d& p, double z_m) {
    return {p.x(), p.y(), z_m};
}

/// Whether some line along an axis of `a` parts the two.
bool parted_by_axes_of(const Footprint& a, const Footprint& b) {
    const Pose2 T_a_b = a.T_map_middle.inverse() * b.T_map_middle;
    const double c = std::abs(std::cos(T_a_b.phi_rad)), s = std::abs(std::sin(T_a_b.phi_rad));
    return std::abs(T_a_b.x_m) > (a.length_m + c * b.length_m + s * b.width_m) / 2 ||
           std::abs(T_a_b.y_m) > (a.width_m + s * b.length_m + c * b.width_m) / 2;
}

}  // namespace

bool overlap(const Footprint& a, const Footprint& b) {
    return !parted_by_axes_of(a, b) && !parted_by_axes_of(b, a);
}

double distance_m(const Footprint& footprint, const Eigen::Vector2d& place_m) {
    const Eigen::Vector2d p_m = footprint.T_map_middle.inverse() * place_m;
    return std::hypot(std::max(std::abs(p_m.x()) - footprint.length_m / 2, 0.0),
                      std::max(std::abs(p_m.y()) - footprint.width_m / 2, 0.0));
}

void add_block(TriangleMesh& mesh, const Footprint& footprint, double bottom_m, double top_m,
               Material material) {
    const Eigen::Vector2d corners_m[] = {footprint.corner_m(1, 1), footprint.corner_m(-1, 1),
                                         footprint.corner_m(-1, -1), footprint.corner_m(1, -1)};
    for (int i = 0; i < 4; ++i) {
        const Eigen::Vector2d &a = corners_m[i], &b = corners_m[(i + 1) % 4];
        mesh.add_quad(at_height(a, bottom_m), at_height(b, bottom_m), at_height(b, top_m),
                      at_height(a, top_m), material);
    }
    mesh.add_quad(at_height(corners_m[0], top_m), at_height(corners_m[1], top_m),
                  at_height(corners_m[2], top_m), at_height(corners_m[3], top_m), material);
}

void add_post(TriangleMesh& mesh, const Eigen::Vector2d& middle_m, double bottom_m, double top_m,
              double radius_m, double top_radius_m, int sides, Material material) {
    const auto on = [&](int i, double r_m) -> Eigen::Vector2d {
        const double a_rad = 2 * M_PI * i / sides;
        return middle_m + r_m * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad));
    };
    for (int i = 0; i < sides; ++i) {
        const Eigen::Vector2d a = on(i, radius_m), b = on(i + 1, radius_m), c = on(i + 1, top_radius_m),
                              d = on(i, top_radius_m);
        mesh.add_quad(at_height(a, bottom_m), at_height(b, bottom_m), at_height(c, top_m),
                      at_height(d, top_m), material);
        mesh.add_triangle(at_height(d, top_m), at_height(c, top_m), at_height(middle_m, top_m), material);
    }
}

void add_blob(TriangleMesh& mesh, const Eigen::Vector3d& middle_m, double radius_m, double half_height_m,
              double roughness, double phase, Material material) {
    constexpr int around = 8, up = 5;
    // Neither the poles nor the seam may differ from triangle to triangle.
    const auto corner_m = [&](int i, int j) -> Eigen::Vector3d {
        const int k = j == 0 || j == up ? 0 : i % around;
        const double a_rad = 2 * M_PI * k / around, e_rad = M_PI * (static_cast<double>(j) / up - 0.5);
        const double bump = std::sin(12.9898 * (k + 1) + 78.233 * (j + 1) + phase) * 43758.5453;
        const double part = 1 - roughness * (bump - std::floor(bump));
        return middle_m + part * Eigen::Vector3d(radius_m * std::cos(e_rad) * std::cos(a_rad),
                                                 radius_m * std::cos(e_rad) * std::sin(a_rad),
                                                 half_height_m * std::sin(e_rad));
    };
    for (int j = 0; j < up; ++j)
        for (int i = 0; i < around; ++i) {
            if (j > 0) mesh.add_triangle(corner_m(i, j), corner_m(i + 1, j), corner_m(i, j + 1), material);
            if (j + 1 < up)
                mesh.add_triangle(corner_m(i + 1, j), corner_m(i + 1, j + 1), corner_m(i, j + 1), material);
        }
}

}  // namespace loopline::simulation
