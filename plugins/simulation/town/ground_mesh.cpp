#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "simulation/town/town.h"

namespace loopline::simulation {
namespace {

constexpr double paved_m = 5;  ///< from the middle of a street
constexpr double look_m = 4;   ///< from place to place along the way

using Cell = std::pair<int, int>;

/// All cells that some part of the way comes near to, in an order of their own.
std::set<Cell> cells_near(const Street& driven, double side_m, double reach_m) {
    std::set<Cell> cells;
    const int reach = static_cast<int>(std::ceil(reach_m / side_m));
    Eigen::Vector2d last_m(1e300, 1e300);
    for (double way_m = 0; way_m < driven.length_m() + look_m; way_m += look_m) {
        const Eigen::Vector2d p = driven.at(std::min(way_m, driven.length_m())).translation();
        // What lies beyond both ends of the rows that a step adds is there already.
        if ((p - last_m).norm() < reach_m / 16 && way_m < driven.length_m()) continue;
        last_m = p;
        const int x = static_cast<int>(std::floor(p.x() / side_m)),
                  y = static_cast<int>(std::floor(p.y() / side_m));
        for (int dy = -reach; dy <= reach; ++dy) {
            const int half = static_cast<int>(std::sqrt(std::max(0, reach * reach - dy * dy)));
            for (int dx = -half; dx <= half; ++dx) cells.emplace(y + dy, x + dx);
        }
    }
    return cells;
}

}  // namespace

void add_ground(TriangleMesh& mesh, const Street& driven, const StreetIndex& streets, const Ground& ground,
                double side_m, double reach_m) {
    const auto corner_m = [&](int x, int y) -> Eigen::Vector3d {
        const Eigen::Vector2d p(x * side_m, y * side_m);
        return {p.x(), p.y(), ground.height_m(p)};
    };
    for (const auto& [y, x] : cells_near(driven, side_m, reach_m)) {
        const Eigen::Vector2d middle_m((x + 0.5) * side_m, (y + 0.5) * side_m);
        const bool paved = streets.distance_m(middle_m, paved_m) < paved_m;
        mesh.add_quad(corner_m(x, y), corner_m(x + 1, y), corner_m(x + 1, y + 1), corner_m(x, y + 1),
                      paved ? Material::asphalt : Material::grass);
    }
}

}  // namespace loopline::simulation
