#include "simulation/world.h"

namespace loopline::simulation {

World transformed(const Pose2& T_a_b, World world_in_b) {
    for (Wall& wall : world_in_b.walls) {
        wall.from_m = T_a_b * wall.from_m;
        wall.to_m = T_a_b * wall.to_m;
    }
    for (FeaturePoint& point : world_in_b.points) point.position_m = T_a_b * point.position_m;
    return world_in_b;
}

}  // namespace loopline::simulation
