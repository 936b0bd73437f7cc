/// Elapsed time, for the timings in metrics.json only: no result depends on it.
#pragma once

#include <chrono>

namespace loopline {

using Clock = std::chrono::steady_clock;

inline double milliseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace loopline
