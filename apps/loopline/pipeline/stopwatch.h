/// Elapsed time, for the timings in metrics.json only: no result depends on it.
#pragma once

#include <chrono>
#include <cstdint>

#if defined(__x86_64__)
#include <cpuid.h>
#include <x86intrin.h>
#endif

namespace loopline {

using Clock = std::chrono::steady_clock;

inline double milliseconds_between(Clock::time_point start, Clock::time_point end) {
    return std::chrono::duration<double, std::milli>(end - start).count();
}

inline double milliseconds_since(Clock::time_point start) {
    return milliseconds_between(start, Clock::now());
}

/// A clock for what takes less time than a look at the system's clock, in units of its own: the processor's
/// time stamp counter where that runs at one speed whatever the processor does, else the system's clock.
class TickClock {
 public:
    TickClock() : counts_(has_steady_counter()), start_ticks_(now()), start_(Clock::now()) {}

    std::int64_t now() const {
#if defined(__x86_64__)
        if (counts_) return static_cast<std::int64_t>(__rdtsc());
#endif
        return Clock::now().time_since_epoch().count();
    }
    /// By how many of them passed since this clock was made.
    double milliseconds_per_tick() const {
        const std::int64_t ticks = now() - start_ticks_;
        return ticks > 0 ? milliseconds_since(start_) / static_cast<double>(ticks) : 0;
    }

 private:
    /// What processors call an invariant counter.
    static bool has_steady_counter() {
#if defined(__x86_64__)
        constexpr unsigned power_management = 0x80000007, invariant = 1U << 8;
        unsigned a = 0, b = 0, c = 0, d = 0;
        return __get_cpuid(power_management, &a, &b, &c, &d) != 0 && (d & invariant) != 0;
#else
        return false;
#endif
    }

    bool counts_;
    std::int64_t start_ticks_;
    Clock::time_point start_;
};

}  // namespace loopline
