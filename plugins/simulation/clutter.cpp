#include "simulation/clutter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/random_stream.h"
#include "simulation/segment.h"

namespace loopline::simulation {
namespace {

constexpr int attempts_per_piece = 30;

struct Piece {
    Eigen::Vector2d centre_m;
    double length_m, width_m, angle_rad, height_m;

    std::array<Eigen::Vector2d, 4> corners_m() const {
        const Pose2 T_world_piece{centre_m.x(), centre_m.y(), angle_rad};
        const double l = length_m / 2, w = width_m / 2;
        return {T_world_piece * Eigen::Vector2d(l, w), T_world_piece * Eigen::Vector2d(-l, w),
                T_world_piece * Eigen::Vector2d(-l, -w), T_world_piece * Eigen::Vector2d(l, -w)};
    }
    double radius_m() const { return std::hypot(length_m, width_m) / 2; }
    /// Half the sides of the rectangle along the axes around it.
    Eigen::Vector2d half_m() const {
        const double c = std::abs(std::cos(angle_rad)), s = std::abs(std::sin(angle_rad));
        return {(length_m * c + width_m * s) / 2, (length_m * s + width_m * c) / 2};
    }
};

Piece drawn_piece(RandomStream& random) {
    const double length_m = random.uniform(0.3, 1.4), width_m = random.uniform(0.25, 0.6);
    const double angle_rad = random.chance(0.75) ? random.index(2) * M_PI / 2 : random.uniform(0, M_PI);
    return {{0, 0}, length_m, width_m, angle_rad, random.uniform(0.6, 1.9)};
}

/// Nearer than `clear_m` to the leg from `a_m` to `b_m`. A leg that cuts through a piece is near its middle
/// or one of its corners.
bool is_near(const Piece& piece, const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m, double clear_m) {
    if (distance_to_segment_m(piece.centre_m, a_m, b_m) > clear_m + piece.radius_m()) return false;
    const auto corners = piece.corners_m();
    bool near = distance_to_segment_m(piece.centre_m, a_m, b_m) < clear_m;
    for (std::size_t i = 0; i < 4; ++i)
        near = near || distance_to_segment_m(corners[i], a_m, b_m) < clear_m ||
               distance_to_segment_m(a_m, corners[i], corners[(i + 1) % 4]) < clear_m ||
               distance_to_segment_m(b_m, corners[i], corners[(i + 1) % 4]) < clear_m;
    return near;
}

bool in_the_way(const Piece& piece, const Waypoints& route, double clear_m) {
    for (std::size_t leg = 0; leg + 1 < route.size(); ++leg)
        if (is_near(piece, route[leg], route[leg + 1], clear_m)) return true;
    return false;
}

/// In a wall, a pillar or a box that is drawn by hand.
bool is_inside_another(const Piece& piece, const std::vector<Wall>& walls) {
    const double least_m = std::min(piece.length_m, piece.width_m) / 2;
    return std::any_of(walls.begin(), walls.end(), [&](const Wall& wall) {
        return distance_to_segment_m(piece.centre_m, wall.from_m, wall.to_m) < least_m;
    });
}

}  // namespace

void add_clutter(World& world, const std::vector<Row>& rectangles, const Waypoints& route, double clear_m,
                 std::uint64_t seed) {
    RandomStream random(seed, "clutter");
    const std::vector<Wall> drawn = world.walls;
    std::vector<Piece> placed;
    for (const Row& r : rectangles) {
        const Eigen::Vector2d low_m(std::min(r[0], r[2]), std::min(r[1], r[3]));
        const Eigen::Vector2d high_m(std::max(r[0], r[2]), std::max(r[1], r[3]));
        int pieces = 0;
        for (int attempt = 0; pieces < r[4] && attempt < r[4] * attempts_per_piece; ++attempt) {
            Piece piece = drawn_piece(random);
            const Eigen::Vector2d from_m = low_m + piece.half_m(), to_m = high_m - piece.half_m();
            piece.centre_m.x() = random.uniform(from_m.x(), to_m.x());
            piece.centre_m.y() = random.uniform(from_m.y(), to_m.y());
            if ((to_m - from_m).minCoeff() < 0 || in_the_way(piece, route, clear_m) ||
                is_inside_another(piece, drawn))
                continue;
            if (std::any_of(placed.begin(), placed.end(), [&](const Piece& other) {
                    return (other.centre_m - piece.centre_m).norm() <
                           other.radius_m() + piece.radius_m() + 0.1;
                }))
                continue;
            add_box(world, piece.centre_m, piece.length_m, piece.width_m, piece.angle_rad, piece.height_m);
            placed.push_back(piece);
            ++pieces;
        }
    }
}

}  // namespace loopline::simulation
