#include "lidar_mapping/upright_walls.h"

#include <Eigen/LU>
#include <cmath>
#include <vector>

namespace loopline::lidar_mapping {
namespace {

constexpr double upright_rad = 15 * M_PI / 180;
/// A plane's own lean, beside what its noise makes: plaster, sills, hedges.
constexpr double sigma_lean_rad = 1 * M_PI / 180;
constexpr double sigma_first_rad = 10 * M_PI / 180;
constexpr int rounds = 8, fewest_walls = 50;

}  // namespace

std::optional<Upright> upright_by_walls(const SurfaceMap& map) {
    struct Wall {
        Eigen::Vector3d normal;
        double variance_rad2;
    };
    std::vector<Wall> walls;
    map.for_each_plane([&](const Eigen::Vector3f& normal, float variance_rad2) {
        if (std::abs(normal.z()) < std::sin(upright_rad))
            walls.push_back({normal.cast<double>(), static_cast<double>(variance_rad2)});
    });
    if (walls.size() < fewest_walls) return std::nullopt;
    // n . Exp(d) z = n_z + n_x d_y - n_y d_x = 0.
    Upright upright;
    Eigen::Vector2d turn = Eigen::Vector2d::Zero();
    for (int round = 0; round < rounds; ++round) {
        // Before any wall, no map leans more than some degrees.
        Eigen::Matrix2d information = Eigen::Matrix2d::Identity() / (sigma_first_rad * sigma_first_rad);
        Eigen::Vector2d gradient = information * turn;
        for (const Wall& wall : walls) {
            const Eigen::Vector2d j(-wall.normal.y(), wall.normal.x());
            const double e = wall.normal.z() + j.dot(turn),
                         per_variance = 1 / (sigma_lean_rad * sigma_lean_rad + wall.variance_rad2),
                         weight = per_variance / (1 + e * e * per_variance);
            information += weight * j * j.transpose();
            gradient += weight * e * j;
        }
        upright.covariance_rad2 = information.inverse();
        turn -= upright.covariance_rad2 * gradient;
    }
    upright.up_map = Eigen::Vector3d(turn.y(), -turn.x(), 1).normalized();
    upright.walls = static_cast<int>(walls.size());
    return upright;
}

}  // namespace loopline::lidar_mapping
