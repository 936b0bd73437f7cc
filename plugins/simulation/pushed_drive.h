/// A cart that a person pushes along a path, by its true motion: for the inertial sensors' sake without any
/// jump of acceleration.
#pragma once

#include <optional>

#include "simulation/drive.h"
#include "simulation/pushed_speed.h"

namespace loopline::simulation {

/// Pushes the cart through the waypoints. It rolls where it points, so hands that let it stray beside the
/// path turn it, too. None if it takes longer than the settings allow.
std::optional<Drive> push_along(const Waypoints& waypoints, const PushSettings& push,
                                const DriveSettings& settings, const VehicleSettings& vehicle,
                                std::uint64_t seed);

/// Wheels that roll where the vehicle goes on the plan: they lose `slip_straight` of their way, in bends the
/// inner one `slip_turn` more, and `sigma_straight_m` at random.
void roll_wheels(Drive& drive, const VehicleSettings& vehicle, double slip_turn, std::uint64_t seed);
/// The same on the ground that the motion was put on: a way uphill is longer than it is on the plan.
void roll_wheels_uphill(Drive& drive, const VehicleSettings& vehicle, double slip_turn, std::uint64_t seed);

}  // namespace loopline::simulation
