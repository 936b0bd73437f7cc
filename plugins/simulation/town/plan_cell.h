/// Squares of the plan as keys of hash tables.
#pragma once

#include <cmath>
#include <cstdint>

namespace loopline::simulation {

inline std::int64_t cell_of(double at_m, double side_m) {
    return static_cast<std::int64_t>(std::floor(at_m / side_m));
}
/// Of the square number `x`, `y`.
inline std::int64_t cell_key(std::int64_t x, std::int64_t y) {
    return x * (std::int64_t{1} << 32) + y;
}

}  // namespace loopline::simulation
