/// A floor of offices around a ring of corridors: rooms with furniture, doors open and closed, people who
/// walk about; and a round that looks into some of the rooms.
#pragma once

#include <cstdint>

#include "simulation/generated_plan.h"

namespace loopline::simulation {

struct OfficeSettings {
    int rooms = 6;  ///< along a corridor, on each of its sides
    double room_width_m = 4.5;
    double room_depth_m = 5;
    double corridor_m = 2.2;
    double wall_m = 0.12;     ///< thickness
    double door_m = 1.0;      ///< width
    double open_doors = 0.5;  ///< part of the doors of rooms that are not visited
    int visits = 8;           ///< rooms that the round leads through
    int clutter = 6;          ///< pieces of furniture in a room
    int people = 10;
};

GeneratedPlan make_office(const OfficeSettings& settings, double height_m, std::uint64_t seed);

}  // namespace loopline::simulation
