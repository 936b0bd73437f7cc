/// Triangles with normals, wound counter-clockwise seen from outside.
#include "render/solids.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace loopline {
namespace {

using Eigen::Vector3d;

mrpt::opengl::TTriangle::Vertex vertex(const Vector3d& p, const Vector3d& normal, Colour colour) {
    mrpt::opengl::TTriangle::Vertex v;
    v.xyzrgba.pt = {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
    v.normal = {static_cast<float>(normal.x()), static_cast<float>(normal.y()),
                static_cast<float>(normal.z())};
    v.setColor(mrpt::img::TColor(colour.red, colour.green, colour.blue));
    return v;
}

/// Corners in turn, with a normal each.
void add_quad(mrpt::opengl::CSetOfTriangles& mesh, const std::array<Vector3d, 4>& p,
              const std::array<Vector3d, 4>& normals, Colour colour) {
    for (const auto& corners : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
        mrpt::opengl::TTriangle triangle;
        for (int i = 0; i < 3; ++i) triangle.vertices[i] = vertex(p[corners[i]], normals[corners[i]], colour);
        mesh.insertTriangle(triangle);
    }
}

void add_flat_quad(mrpt::opengl::CSetOfTriangles& mesh, const std::array<Vector3d, 4>& p, Colour colour) {
    const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[1]).normalized();
    add_quad(mesh, p, {normal, normal, normal, normal}, colour);
}

/// Side direction of a path that runs along `direction`: level where it can be.
Vector3d side_of(const Vector3d& direction) {
    const Vector3d side = direction.cross(Vector3d::UnitZ());
    return side.norm() > 1e-6 ? Vector3d(side.normalized()) : Vector3d(Vector3d::UnitX());
}

}  // namespace

void add_tube(mrpt::opengl::CSetOfTriangles& mesh, const std::vector<Vector3d>& vertices_m, double radius_m,
              Colour colour) {
    constexpr int sides = 8;
    const std::size_t count = vertices_m.size();
    std::array<Vector3d, sides> normals, last_normals;
    for (std::size_t i = 0; i < count && count > 1; ++i) {
        const Vector3d& before = vertices_m[i > 0 ? i - 1 : 0];
        const Vector3d& after = vertices_m[i + 1 < count ? i + 1 : i];
        Vector3d direction = (vertices_m[i] - before).normalized() + (after - vertices_m[i]).normalized();
        if (!(direction.norm() > 1e-3)) direction = after - vertices_m[i];
        direction.normalize();
        const Vector3d side = side_of(direction), up = side.cross(direction);
        for (int k = 0; k < sides; ++k) {
            const double angle = 2 * M_PI * k / sides;
            normals[k] = std::cos(angle) * side + std::sin(angle) * up;
        }
        for (int k = 0; i > 0 && k < sides; ++k) {
            const int next = (k + 1) % sides;
            add_quad(mesh,
                     {before + radius_m * last_normals[k], vertices_m[i] + radius_m * normals[k],
                      vertices_m[i] + radius_m * normals[next], before + radius_m * last_normals[next]},
                     {last_normals[k], normals[k], normals[next], last_normals[next]}, colour);
        }
        last_normals = normals;
    }
}

void add_wall(mrpt::opengl::CSetOfTriangles& mesh, const Eigen::Vector2d& start_m,
              const Eigen::Vector2d& end_m, double floor_m, double height_m, double thickness_m, Colour sides,
              Colour top) {
    if (!start_m.allFinite() || !end_m.allFinite() || (end_m - start_m).norm() < 1e-6) return;
    const Eigen::Vector2d along = (end_m - start_m).normalized() * thickness_m / 2,
                          across(-along.y(), along.x());
    const std::array<Eigen::Vector2d, 4> outline = {start_m - along - across, end_m + along - across,
                                                    end_m + along + across, start_m - along + across};
    const auto at = [](const Eigen::Vector2d& p, double z) { return Vector3d(p.x(), p.y(), z); };
    const double ceiling_m = floor_m + height_m;
    for (int i = 0; i < 4; ++i) {
        const auto &a = outline[i], &b = outline[(i + 1) % 4];
        add_flat_quad(mesh, {at(a, floor_m), at(b, floor_m), at(b, ceiling_m), at(a, ceiling_m)}, sides);
    }
    add_flat_quad(mesh,
                  {at(outline[0], ceiling_m), at(outline[1], ceiling_m), at(outline[2], ceiling_m),
                   at(outline[3], ceiling_m)},
                  top);
}

void add_cart(mrpt::opengl::CSetOfTriangles& mesh, const Pose2& T_map_base, double floor_m, Colour body,
              Colour arrow) {
    using Eigen::Vector2d;
    constexpr Colour rubber{52, 58, 66};
    const auto slab = [&](double x0, double x1, double y, double low_m, double height_m, double thickness_m,
                          Colour colour) {
        // add_wall() lengthens a slab by half its thickness at both ends.
        add_wall(mesh, T_map_base * Vector2d(x0 + thickness_m / 2, y),
                 T_map_base * Vector2d(x1 - thickness_m / 2, y), floor_m + low_m, height_m, thickness_m,
                 colour, colour);
    };
    for (const double y : {-0.23, 0.23}) {
        slab(-0.24, -0.06, y, 0, 0.18, 0.08, rubber);
        slab(0.06, 0.24, y, 0, 0.18, 0.08, rubber);
    }
    slab(-0.3, 0.3, 0, 0.08, 0.2, 0.36, body);
    const double deck_m = floor_m + 0.285;
    const auto on_deck = [&](double x, double y) {
        const Vector2d p = T_map_base * Vector2d(x, y);
        return Vector3d(p.x(), p.y(), deck_m);
    };
    add_flat_quad(mesh, {on_deck(-0.22, 0.14), on_deck(-0.12, 0), on_deck(-0.22, -0.14), on_deck(0.26, 0)},
                  arrow);
}

void add_pin(mrpt::opengl::CSetOfTriangles& mesh, const Vector3d& base_m, double height_m,
             double ball_radius_m, Colour colour) {
    const Vector3d centre_m = base_m + height_m * Vector3d::UnitZ();
    add_tube(mesh, {base_m, centre_m}, 0.22 * ball_radius_m, colour);
    constexpr int rings = 8, segments = 16;
    const auto normal = [](int ring, int segment) {
        const double polar = M_PI * ring / rings, azimuth = 2 * M_PI * segment / segments;
        return Vector3d(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                        std::cos(polar));
    };
    for (int ring = 0; ring < rings; ++ring)
        for (int segment = 0; segment < segments; ++segment) {
            const std::array<Vector3d, 4> n = {normal(ring, segment), normal(ring + 1, segment),
                                               normal(ring + 1, segment + 1), normal(ring, segment + 1)};
            add_quad(mesh,
                     {centre_m + ball_radius_m * n[0], centre_m + ball_radius_m * n[1],
                      centre_m + ball_radius_m * n[2], centre_m + ball_radius_m * n[3]},
                     n, colour);
        }
}

}  // namespace loopline
