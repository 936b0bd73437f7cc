/// Directions as parts of a turn, quickly.
#pragma once

#include <algorithm>
#include <cmath>

namespace loopline::cloud_map {

/// Abramowitz and Stegun 1964, 4.4.49, as turns counter-clockwise from behind: 0 .. 1, right to 1e-5 rad.
inline float azimuth_turns(float y, float x) {
    constexpr auto pi = static_cast<float>(M_PI);
    const float ax = std::abs(x), ay = std::abs(y);
    const float z = std::min(ax, ay) / std::max(std::max(ax, ay), 1e-9f), z2 = z * z;
    const float octant =
        z * (0.9998660f + z2 * (-0.3302995f + z2 * (0.1801410f + z2 * (-0.0851330f + z2 * 0.0208351f))));
    const float quadrant = ay > ax ? pi / 2 - octant : octant;
    const float half = x < 0 ? pi - quadrant : quadrant;
    return ((y < 0 ? -half : half) + pi) * (0.5f / pi);
}

}  // namespace loopline::cloud_map
