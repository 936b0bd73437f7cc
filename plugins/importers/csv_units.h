/// Which column of a table holds a quantity, and in which unit: "steering_wheel_deg in deg times -1".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/stamp.h"

namespace loopline::csv {

enum class Quantity { time, length, variance, angle, turn_rate, speed, acceleration, number };

struct Unit {
    const char* name;
    double si;  ///< what one of it is: in s, m, m^2, rad, rad/s, m/s, m/s^2
};

/// The units of a quantity, that of SI first.
const std::vector<Unit>& units_of(Quantity quantity);
/// "speed", "turn rate", ...
const char* name_of(Quantity quantity);

struct ColumnChoice {
    std::string name;                   ///< of the column; empty where `number` counts
    std::optional<std::size_t> number;  ///< from 0
    double factor = 1;                  ///< of the number in the file, to SI
};

/// "NAME", "NAME in UNIT", "NAME in UNIT times FACTOR"; NAME may stand in double quotes, and "column 3" is
/// the third one whatever its name. Without a unit it is that of SI; but angles and turn rates must say
/// theirs, since both of them are common and neither is strange enough to be noticed. `problem` is a clause
/// that fits after the key, or empty.
struct ParsedColumn {
    ColumnChoice choice;
    std::string problem;
};
ParsedColumn column_from_text(const std::string& text, Quantity quantity);

/// Of a decimal number times 10^power: all digits count, so that nanoseconds of this century are exact.
/// Nothing if the text is no such number.
std::optional<StampNs> time_from_text(std::string_view text, int power_of_ten);

}  // namespace loopline::csv
