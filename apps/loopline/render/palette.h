/// Colours of pictures and report: Okabe and Ito's set for the data, which stays apart for every common kind
/// of colour blindness; shape and dash tell the same things again.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace loopline {

struct Colour {
    unsigned char red = 0, green = 0, blue = 0;
};

namespace palette {
inline constexpr Colour paper{255, 255, 255};
inline constexpr Colour ink{29, 36, 44};
inline constexpr Colour quiet_ink{95, 105, 117};
inline constexpr Colour frame{196, 203, 211};
inline constexpr Colour graticule{229, 233, 238};

inline constexpr Colour estimate{0, 114, 178};        // blue
inline constexpr Colour dead_reckoning{230, 159, 0};  // orange
inline constexpr Colour start{0, 158, 115};           // bluish green
inline constexpr Colour end{213, 94, 0};              // vermilion
inline constexpr Colour wall{29, 36, 44};
inline constexpr Colour scan_point{96, 125, 150};
inline constexpr Colour late_point = end;
inline constexpr Colour reverse{204, 121, 167};  // reddish purple

inline constexpr Colour grid_free{243, 246, 249};
inline constexpr Colour grid_occupied{176, 186, 197};

/// Colour of a height, `share` 0 (lowest) to 1 (highest): viridis without its light end, which is lost on
/// white.
inline Colour height(double share) {
    constexpr std::array<Colour, 7> ramp{{{68, 1, 84},
                                          {70, 50, 126},
                                          {54, 92, 141},
                                          {39, 127, 142},
                                          {31, 161, 135},
                                          {74, 193, 109},
                                          {160, 206, 56}}};
    const double at = std::clamp(share, 0.0, 1.0) * (ramp.size() - 1);
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(at), ramp.size() - 2);
    const auto mix = [&](unsigned char a, unsigned char b) {
        return static_cast<unsigned char>(a + (at - static_cast<double>(i)) * (b - a) + 0.5);
    };
    return {mix(ramp[i].red, ramp[i + 1].red), mix(ramp[i].green, ramp[i + 1].green),
            mix(ramp[i].blue, ramp[i + 1].blue)};
}
}  // namespace palette

}  // namespace loopline
