#include <algorithm>
#include <cmath>

#include "simulation/random_stream.h"
#include "simulation/town/town.h"

namespace loopline::simulation {
namespace {

constexpr double rib_m = 1.5;        ///< from rib to rib
constexpr double rock_m = 0.12;      ///< how far a wall of rock strays
constexpr double wall_sunk_m = 0.3;  ///< walls begin below the ground
constexpr int pillar_every = 6;      ///< pieces
constexpr double pillar_m = 0.6;

/// The outline of the gallery at one place: feet and shoulders of both walls.
struct Rib {
    Eigen::Vector3d right_foot_m, right_m, left_m, left_foot_m;
};

/// Walls and ceiling from one rib to the next.
void add_vault(TriangleMesh& mesh, const Rib& last, const Rib& next) {
    mesh.add_quad(last.right_foot_m, next.right_foot_m, next.right_m, last.right_m, Material::concrete);
    mesh.add_quad(last.right_m, next.right_m, next.left_m, last.left_m, Material::concrete);
    mesh.add_quad(last.left_m, next.left_m, next.left_foot_m, last.left_foot_m, Material::concrete);
}

}  // namespace

void add_gallery(TriangleMesh& mesh, const Street& driven, const Ground& ground, double from_m, double to_m,
                 double width_m, double height_m, std::uint64_t seed) {
    RandomStream random(seed, "gallery");
    const auto rib_at = [&](double way_m) -> Rib {
        const Pose2 T_map_way = driven.at(way_m);
        const double floor_m = ground.height_m(T_map_way.translation());
        const auto at = [&](double left_m, double z_m) -> Eigen::Vector3d {
            const Eigen::Vector2d p = T_map_way * Eigen::Vector2d(random.uniform(-rock_m, rock_m),
                                                                  left_m + random.uniform(-rock_m, rock_m));
            return {p.x(), p.y(), floor_m + z_m + random.uniform(-rock_m, rock_m)};
        };
        return {at(-width_m / 2, -wall_sunk_m), at(-width_m / 2, height_m), at(width_m / 2, height_m),
                at(width_m / 2, -wall_sunk_m)};
    };
    Rib last = rib_at(from_m);
    const int pieces = std::max(1, static_cast<int>((to_m - from_m) / rib_m));
    for (int i = 1; i <= pieces; ++i) {
        const double way_m = from_m + (to_m - from_m) * i / pieces;
        const Rib next = rib_at(way_m);
        add_vault(mesh, last, next);
        last = next;
        if (i % pillar_every != 0) continue;
        for (const double side : {-1.0, 1.0}) {
            const Pose2 T_map_pillar =
                driven.at(way_m + random.uniform(-1, 1)) * Pose2{0, side * (width_m / 2 - 0.2), 0};
            const double floor_m = ground.height_m(T_map_pillar.translation());
            add_block(mesh, {T_map_pillar, pillar_m, pillar_m}, floor_m - wall_sunk_m, floor_m + height_m,
                      Material::concrete);
        }
    }
}

void add_tunnel(TriangleMesh& mesh, const Street& driven, const Ground& ground, double from_m, double to_m,
                double width_m, double height_m) {
    const auto rib_at = [&](double way_m) -> Rib {
        const Pose2 T_map_way = driven.at(way_m);
        const double floor_m = ground.height_m(T_map_way.translation());
        const auto at = [&](double left_m, double z_m) -> Eigen::Vector3d {
            const Eigen::Vector2d p = T_map_way * Eigen::Vector2d(0, left_m);
            return {p.x(), p.y(), floor_m + z_m};
        };
        return {at(-width_m / 2, -wall_sunk_m), at(-width_m / 2, height_m), at(width_m / 2, height_m),
                at(width_m / 2, -wall_sunk_m)};
    };
    const int pieces = std::max(1, static_cast<int>((to_m - from_m) / rib_m));
    Rib last = rib_at(from_m);
    for (int i = 1; i <= pieces; ++i) {
        const Rib next = rib_at(from_m + (to_m - from_m) * i / pieces);
        add_vault(mesh, last, next);
        last = next;
    }
}

}  // namespace loopline::simulation
