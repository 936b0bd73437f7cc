/// Furniture drawn by the seed: boxes in rectangles that a scenario names, clear of the route.
#pragma once

#include <cstdint>

#include "simulation/floor_plan.h"

namespace loopline::simulation {

/// A row is x0 y0 x1 y1 pieces: a rectangle along the axes. No piece is nearer to the route than `clear_m`
/// (0.4 at least), nearer to another one than 0.1 m, or in a wall of the world; what finds no place is left
/// out.
void add_clutter(World& world, const std::vector<Row>& rectangles, const Waypoints& route, double clear_m,
                 std::uint64_t seed);

}  // namespace loopline::simulation
