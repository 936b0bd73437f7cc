#include "simulation/cart_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace loopline::simulation {
namespace {

constexpr double straight_on_rad = 1e-9;

double heading_rad(const Waypoints& waypoints, std::size_t leg) {
    const Eigen::Vector2d way_m = waypoints[leg + 1] - waypoints[leg];
    return std::atan2(way_m.y(), way_m.x());
}

double corner_rad(const Waypoints& waypoints, std::size_t corner) {
    return wrap_to_pi(heading_rad(waypoints, corner) - heading_rad(waypoints, corner - 1));
}

/// The integral of the bend's curvature.
double bend_heading_rad(double turn_rad, double u) {
    return turn_rad * (u - std::sin(2 * M_PI * u) / (2 * M_PI));
}

/// The part 0 .. u of a bend of length 1, from its beginning, by Simpson's rule.
Pose2 bend_pose(double turn_rad, double u) {
    constexpr int halves = 32;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (int i = 0; i <= halves; ++i) {
        const double weight = i == 0 || i == halves ? 1 : i % 2 == 1 ? 4 : 2;
        const double phi_rad = bend_heading_rad(turn_rad, u * i / halves);
        sum += weight * Eigen::Vector2d(std::cos(phi_rad), std::sin(phi_rad));
    }
    sum *= u / (3 * halves);
    return {sum.x(), sum.y(), bend_heading_rad(turn_rad, u)};
}

/// From the corner to either end of a bend of length 1, which is symmetric.
double tangent(double turn_rad) {
    return bend_pose(turn_rad, 1).translation().norm() / (2 * std::cos(turn_rad / 2));
}

}  // namespace

void CartPath::append(double length_m, const Pose2& T_world_begin, double turn_rad) {
    pieces_.push_back({pieces_.empty() ? 0 : this->length_m(), length_m, T_world_begin, turn_rad});
}

CartPath::CartPath(const Waypoints& waypoints, double corner_radius_m) {
    assert(waypoints.size() >= 2);
    double taken_m = 0;  // of the leg, by the bend before it
    for (std::size_t leg = 0; leg + 1 < waypoints.size(); ++leg) {
        const double phi_rad = heading_rad(waypoints, leg);
        const Eigen::Vector2d ahead(std::cos(phi_rad), std::sin(phi_rad));
        const double leg_m = (waypoints[leg + 1] - waypoints[leg]).norm();
        const Eigen::Vector2d begin_m = waypoints[leg] + taken_m * ahead;
        double turn_rad = 0, bend_m = 0, tangent_m = 0;
        if (leg + 2 < waypoints.size()) {
            turn_rad = corner_rad(waypoints, leg + 1);
            if (std::abs(turn_rad) < straight_on_rad) turn_rad = 0;
            const double next_m = (waypoints[leg + 2] - waypoints[leg + 1]).norm();
            bend_m = std::min(2 * std::abs(turn_rad) * corner_radius_m,
                              std::min(leg_m, next_m) / 2 / tangent(turn_rad));
            tangent_m = bend_m * tangent(turn_rad);
        }
        append(leg_m - taken_m - tangent_m, {begin_m.x(), begin_m.y(), phi_rad}, 0);
        const Eigen::Vector2d end_m = waypoints[leg + 1] - tangent_m * ahead;
        if (bend_m > 0) append(bend_m, {end_m.x(), end_m.y(), phi_rad}, turn_rad);
        taken_m = tangent_m;
    }
}

PathPoint CartPath::at(double way_m) const {
    const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), way_m,
                                        [](double way, const Piece& piece) { return way < piece.begin_m; });
    const Piece& piece = after == pieces_.begin() ? *after : *(after - 1);
    const double inside_m = std::clamp(way_m - piece.begin_m, 0.0, piece.length_m);
    if (piece.turn_rad == 0) return {piece.T_world_begin * Pose2{inside_m, 0, 0}, 0};
    const double u = inside_m / piece.length_m;
    Pose2 bend = bend_pose(piece.turn_rad, u);
    bend.x_m *= piece.length_m;
    bend.y_m *= piece.length_m;
    return {piece.T_world_begin * bend, piece.turn_rad / piece.length_m * (1 - std::cos(2 * M_PI * u))};
}

double CartPath::sharpest_turn_rad(const Waypoints& waypoints) {
    double sharpest_rad = 0;
    for (std::size_t corner = 1; corner + 1 < waypoints.size(); ++corner)
        sharpest_rad = std::max(sharpest_rad, std::abs(corner_rad(waypoints, corner)));
    return sharpest_rad;
}

}  // namespace loopline::simulation
