#include "api/stamp.h"

#include <array>
#include <cctype>
#include <cstdio>
#include <limits>

namespace loopline {
namespace {
constexpr StampNs nanoseconds_per_second = 1'000'000'000;
constexpr StampNs ns_per_tick = 100;
constexpr std::int64_t ticks_1601_to_1970 = 116'444'736'000'000'000;
}  // namespace

std::optional<StampNs> stamp_from_mrpt(const mrpt::Clock::time_point& time) {
    const std::int64_t ticks = time.time_since_epoch().count();
    if (ticks == 0) return std::nullopt;
    const std::int64_t ticks_since_1970 = ticks - ticks_1601_to_1970;
    // A damaged stamp may lie outside what 64 bits of nanoseconds hold (years 1678 to 2262).
    if (ticks_since_1970 > std::numeric_limits<StampNs>::max() / ns_per_tick ||
        ticks_since_1970 < std::numeric_limits<StampNs>::min() / ns_per_tick)
        return std::nullopt;
    return ticks_since_1970 * ns_per_tick;
}

mrpt::Clock::time_point stamp_to_mrpt(StampNs stamp_ns) {
    return mrpt::Clock::time_point(mrpt::Clock::duration(stamp_ns / ns_per_tick + ticks_1601_to_1970));
}

std::string seconds_text(StampNs stamp_ns) {
    const bool negative = stamp_ns < 0;
    const auto magnitude =
        negative ? 0 - static_cast<std::uint64_t>(stamp_ns) : static_cast<std::uint64_t>(stamp_ns);
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%s%llu.%09llu", negative ? "-" : "",
                  static_cast<unsigned long long>(magnitude / nanoseconds_per_second),
                  static_cast<unsigned long long>(magnitude % nanoseconds_per_second));
    return text.data();
}

std::optional<StampNs> stamp_from_seconds_text(std::string_view seconds) {
    std::size_t i = 0;
    const bool negative = !seconds.empty() && seconds[0] == '-';
    if (negative) ++i;
    std::int64_t whole = 0, fraction = 0, scale = nanoseconds_per_second;
    std::size_t digits = 0;
    for (; i < seconds.size() && std::isdigit(static_cast<unsigned char>(seconds[i])); ++i, ++digits) {
        if (whole > 9'000'000'000) return std::nullopt;
        whole = whole * 10 + (seconds[i] - '0');
    }
    if (i < seconds.size() && seconds[i] == '.')
        for (++i; i < seconds.size() && std::isdigit(static_cast<unsigned char>(seconds[i])); ++i, ++digits) {
            if (scale == 1) continue;  // below a nanosecond
            scale /= 10;
            fraction += (seconds[i] - '0') * scale;
        }
    if (digits == 0 || i != seconds.size() || whole > 9'000'000'000) return std::nullopt;
    const std::int64_t magnitude = whole * nanoseconds_per_second + fraction;
    return negative ? -magnitude : magnitude;
}

}  // namespace loopline
