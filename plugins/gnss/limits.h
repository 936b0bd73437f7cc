/// Units of receivers, times of day, and what numbers can be at most.
#pragma once

#include "api/stamp.h"

namespace loopline::gnss {

constexpr double mps_per_knot = 1852.0 / 3600;
constexpr StampNs day_ns = 86'400'000'000'000;

/// The moment with this time of day that is nearest to another.
inline StampNs nearest_moment_ns(StampNs time, StampNs to_ns) {
    const StampNs off_ns = to_ns - time;
    const StampNs days = off_ns >= 0 ? (off_ns + day_ns / 2) / day_ns : (off_ns - day_ns / 2) / day_ns;
    return days * day_ns + time;
}

constexpr double most_height_m = 1e8;  ///< beyond any satellite
constexpr double most_sigma_m = 1e6;
constexpr double most_speed_mps = 1e4;
constexpr double most_dop = 1e4;

}  // namespace loopline::gnss
