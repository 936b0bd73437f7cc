/// People who walk to and fro, and step aside for the vehicle.
#pragma once

#include <vector>

#include "simulation/ray_caster.h"
#include "simulation/true_motion.h"

namespace loopline::simulation {

/// Walks between two places at constant speed, world frame.
struct Walker {
    Eigen::Vector2d from_m, to_m;
    double speed_mps = 1;
    double phase = 0;  ///< 0 .. 1: where on the way there and back it starts
    double radius_m = 0.2;
    double top_m = 1.7;
};

/// Where the walkers are when the vehicle is at `vehicle_m`; none comes nearer to it than `distance_m`.
std::vector<Cylinder> walkers_at(const std::vector<Walker>& walkers, StampNs time_ns,
                                 const Eigen::Vector2d& vehicle_m, double distance_m = 0.7);

}  // namespace loopline::simulation
