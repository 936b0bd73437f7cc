/// A world drawn by rows of numbers, as a scenario's [world] section gives them: walls, doors set back in
/// them, pilasters that stand out of them, partitions, boxes, and the points that results are compared at.
#pragma once

#include <string>
#include <vector>

#include "simulation/world.h"

namespace loopline::simulation {

using Row = std::vector<double>;

struct FloorPlan {
    double height_m = 2.8;
    double door_height_m = 2.1;
    bool ceiling = true;
    std::vector<Row> walls;  ///< x y x y ...: a chain of walls
    std::vector<Row>
        doors;  ///< x1 y1 x2 y2 depth: part of a wall, set back to the left of the way from 1 to 2
    std::vector<Row> pilasters;  ///< the same from floor to ceiling: it stands out to the left
    std::vector<Row> boxes;  ///< x y length width turn_deg height: centre, and length along the turned x axis
    std::vector<Row> partitions;  ///< x1 y1 x2 y2 thickness: a wall that has two sides, about its middle line
    std::vector<Row> clutter;     ///< x0 y0 x1 y1 pieces: see add_clutter(); not built by build_world()
    double clutter_clear_m = 1;   ///< of the route
    std::vector<Row> points;      ///< number x y
};

/// What is wrong with the row `row` of `key` ("door_m").
struct PlanProblem {
    std::string key;
    std::size_t row = 0;
    std::string sentence;  ///< a clause that fits after the key
};

/// Doors and pilasters cut the wall that they lie on, in the order of their rows. What is wrong goes to
/// `problems` and is left out.
World build_world(const FloorPlan& plan, std::vector<PlanProblem>& problems);

/// Four walls; `length_m` along `angle_rad`.
void add_box(World& world, const Eigen::Vector2d& centre_m, double length_m, double width_m, double angle_rad,
             double height_m);

}  // namespace loopline::simulation
