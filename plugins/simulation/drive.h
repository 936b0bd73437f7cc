/// A whole drive, from the first waypoint to the last: true path, wheels and commands.
#pragma once

#include <optional>
#include <vector>

#include "simulation/driver.h"
#include "simulation/true_motion.h"

namespace loopline::simulation {

struct DriveSettings {
    double step_s = 0.005;
    double control_s = 0.05;   ///< from command to command
    double longest_s = 36000;  ///< a drive that takes longer does not arrive
};

/// A command, from its time on.
struct Command {
    StampNs time_ns = 0;
    Regime regime = Regime::straight;
};

struct Drive {
    TrueMotion motion;             ///< world frame
    std::vector<WheelPair> rim_m;  ///< way of the rims since the start, at the end of each step
    std::vector<Command> commands;

    /// Way of the rims since the start.
    WheelPair rim_at(StampNs time_ns) const;
};

/// Drives the route. None if the vehicle does not arrive.
std::optional<Drive> drive_route(const Waypoints& waypoints, const DriveSettings& settings,
                                 const DriverSettings& driver, const VehicleSettings& vehicle,
                                 std::uint64_t seed);

}  // namespace loopline::simulation
