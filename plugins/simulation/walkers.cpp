#include "simulation/walkers.h"

#include <cmath>

namespace loopline::simulation {

std::vector<Cylinder> walkers_at(const std::vector<Walker>& walkers, StampNs time_ns,
                                 const Eigen::Vector2d& vehicle_m, double distance_m) {
    std::vector<Cylinder> cylinders;
    cylinders.reserve(walkers.size());
    for (const Walker& walker : walkers) {
        const Eigen::Vector2d way_m = walker.to_m - walker.from_m;
        const double there_and_back_s = 2 * way_m.norm() / walker.speed_mps;
        const double turns = walker.phase + seconds_between(0, time_ns) / there_and_back_s;
        const double part = 1 - std::abs(1 - 2 * (turns - std::floor(turns)));  // 0 to 1 and back
        Eigen::Vector2d place_m = walker.from_m + part * way_m;
        const Eigen::Vector2d off_m = place_m - vehicle_m;
        if (const double off = off_m.norm(); off < distance_m)
            place_m = vehicle_m + (off > 1e-6 ? Eigen::Vector2d(off_m * (distance_m / off))
                                              : Eigen::Vector2d(distance_m, 0));
        cylinders.push_back({place_m, walker.radius_m, walker.top_m});
    }
    return cylinders;
}

}  // namespace loopline::simulation
