/// Time: integer nanoseconds since 1970-01-01 UTC inside, seconds with nine decimals at the interface.
#pragma once

#include <mrpt/core/Clock.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace loopline {

using StampNs = std::int64_t;

/// MRPT counts 100 ns from 1601; the difference to 1970 is exact in integers. `nullopt` for
/// INVALID_TIMESTAMP.
std::optional<StampNs> stamp_from_mrpt(const mrpt::Clock::time_point& time);
mrpt::Clock::time_point stamp_to_mrpt(StampNs stamp_ns);

/// "1137834225.973760000": every digit of the integer, none of a double's rounding.
std::string seconds_text(StampNs stamp_ns);
/// The inverse of seconds_text(), also for fewer decimals or none; `nullopt` if it is not a decimal number.
std::optional<StampNs> stamp_from_seconds_text(std::string_view seconds);

inline double seconds_between(StampNs earlier_ns, StampNs later_ns) {
    return static_cast<double>(later_ns - earlier_ns) * 1e-9;
}

}  // namespace loopline
