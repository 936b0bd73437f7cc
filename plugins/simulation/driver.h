/// Keeps a vehicle on its route by its three ways to drive, looking at its true pose.
#pragma once

#include "api/pose2.h"
#include "simulation/vehicle.h"
#include "simulation/world.h"

namespace loopline::simulation {

struct DriverSettings {
    double deadband_rad = 3 * M_PI / 180;         ///< heading error that calls for a short turn
    double approach_rad_per_m = 20 * M_PI / 180;  ///< heading back to the leg for a metre beside it
    double max_approach_rad = 15 * M_PI / 180;
};

/// Legs from waypoint to waypoint, joined by turns. A turn begins so far before the corner that its arc leads
/// onto the next leg.
class Driver {
 public:
    /// At least two waypoints, no two in one place.
    Driver(Waypoints waypoints, const DriverSettings& settings, const VehicleSettings& vehicle);

    /// At the first waypoint, towards the second.
    Pose2 start() const;
    Regime command(const Pose2& T_world_base);
    bool arrived() const { return arrived_; }

 private:
    double leg_heading_rad(std::size_t leg) const;
    Regime turn_until(double error_rad);

    Waypoints waypoints_;
    DriverSettings settings_;
    double turn_radius_m_ = 0;
    double overrun_rad_ = 0;  ///< by which the heading still changes after a turn has been stopped
    std::size_t leg_ = 0;
    Regime regime_ = Regime::straight;
    bool arrived_ = false;
};

}  // namespace loopline::simulation
