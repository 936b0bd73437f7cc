/// What numbers of a receiver can be at most, and its units.
#pragma once

#include "api/stamp.h"

namespace loopline::gnss {

constexpr double mps_per_knot = 1852.0 / 3600;
constexpr StampNs day_ns = 86'400'000'000'000;

constexpr double most_height_m = 1e8;  ///< beyond any satellite
constexpr double most_sigma_m = 1e6;
constexpr double most_speed_mps = 1e4;
constexpr double most_dop = 1e4;

}  // namespace loopline::gnss
