/// A smooth way through waypoints: straight legs, joined by bends whose curvature rises and falls without a
/// jump.
#pragma once

#include <vector>

#include "api/pose2.h"
#include "simulation/world.h"

namespace loopline::simulation {

struct PathPoint {
    Pose2 T_world_path;  ///< x ahead along the path
    double curvature_per_m = 0;
};

/// A bend by the angle theta has the curvature (theta / L) (1 - cos(2 pi u)), u = 0 .. 1 along its length L.
/// Curvature and its derivative vanish at both ends.
class CartPath {
 public:
    /// At least two waypoints, no two neighbours in one place. A bend has `corner_radius_m` where it is
    /// tightest, less if the legs are too short for that.
    CartPath(const Waypoints& waypoints, double corner_radius_m);

    double length_m() const { return pieces_.back().begin_m + pieces_.back().length_m; }
    /// After `way_m` from the first waypoint, within 0 .. length_m().
    PathPoint at(double way_m) const;

    /// The largest angle between two legs.
    static double sharpest_turn_rad(const Waypoints& waypoints);

 private:
    struct Piece {
        double begin_m, length_m;
        Pose2 T_world_begin;
        double turn_rad;  ///< 0: straight
    };
    void append(double length_m, const Pose2& T_world_begin, double turn_rad);

    std::vector<Piece> pieces_;
};

}  // namespace loopline::simulation
