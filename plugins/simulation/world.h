/// What the simulated sensors see: upright walls on level ground, below a ceiling or the sky.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "api/pose2.h"

namespace loopline::simulation {

/// A vertical rectangle over the segment from `from_m` to `to_m`, world frame.
struct Wall {
    Eigen::Vector2d from_m, to_m;
    double bottom_m = 0;
    double top_m = 0;
};

/// A corner that a result is compared with: the end of a wall.
struct FeaturePoint {
    int number = 0;
    Eigen::Vector2d position_m;
};

struct World {
    std::vector<Wall> walls;
    std::vector<FeaturePoint> points;
    double ground_m = 0;
    double ceiling_m = std::numeric_limits<double>::infinity();
};

/// The same world in the frame `a`, where `T_a_b` maps its coordinates to.
World transformed(const Pose2& T_a_b, World world_in_b);

/// Where the vehicle is to drive, world frame.
using Waypoints = std::vector<Eigen::Vector2d>;

}  // namespace loopline::simulation
