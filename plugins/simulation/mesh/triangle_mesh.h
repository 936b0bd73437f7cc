/// What a spinning lidar sees: triangles, each of some material.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace loopline::simulation {

enum class Material : std::uint8_t {
    asphalt,
    pavement,
    grass,
    plaster,
    brick,
    concrete,
    glass,
    paint,
    metal,
    bark,
    foliage
};

/// How a beam comes back from it.
struct Optics {
    double reflectance = 0;  ///< of light that falls on it square
    double depth_m = 0;      ///< how far a beam may go into it before it meets a leaf
    double lost = 0;         ///< part of the beams that goes through it, or off as from a mirror
};
inline Optics optics_of(Material material) {
    switch (material) {
        case Material::asphalt:
            return {0.12, 0, 0};
        case Material::pavement:
            return {0.25, 0, 0};
        case Material::grass:
            return {0.3, 0.05, 0};
        case Material::plaster:
            return {0.5, 0, 0};
        case Material::brick:
            return {0.35, 0, 0};
        case Material::concrete:
            return {0.3, 0, 0};
        case Material::glass:
            return {0.05, 0, 0.7};
        case Material::paint:
            return {0.4, 0, 0};
        case Material::metal:
            return {0.3, 0, 0};
        case Material::bark:
            return {0.2, 0, 0};
        case Material::foliage:
            return {0.4, 0.5, 0.1};
    }
    return {};
}

struct TriangleMesh {
    std::vector<Eigen::Vector3f> vertices_m;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Material> materials;  ///< of each triangle

    void add_triangle(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m, const Eigen::Vector3d& c_m,
                      Material material) {
        const auto first = static_cast<std::uint32_t>(vertices_m.size());
        for (const Eigen::Vector3d* p : {&a_m, &b_m, &c_m}) vertices_m.push_back(p->cast<float>());
        triangles.push_back({first, first + 1, first + 2});
        materials.push_back(material);
    }
    /// Corners in their order around it.
    void add_quad(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m, const Eigen::Vector3d& c_m,
                  const Eigen::Vector3d& d_m, Material material) {
        const auto first = static_cast<std::uint32_t>(vertices_m.size());
        for (const Eigen::Vector3d* p : {&a_m, &b_m, &c_m, &d_m}) vertices_m.push_back(p->cast<float>());
        triangles.push_back({first, first + 1, first + 2});
        triangles.push_back({first, first + 2, first + 3});
        materials.insert(materials.end(), 2, material);
    }
};

}  // namespace loopline::simulation
