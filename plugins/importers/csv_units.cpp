#include "importers/csv_units.h"

#include <cmath>

#include "api/parameters.h"
#include "config/did_you_mean.h"

namespace loopline::csv {
namespace {

constexpr double rad = 1, deg = M_PI / 180, gravity_mps2 = 9.80665;

std::string trimmed(const std::string& text) {
    const auto first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

std::vector<std::string> unit_names(Quantity quantity) {
    std::vector<std::string> names;
    for (const Unit& unit : units_of(quantity)) names.push_back(unit.name);
    return names;
}

/// What stands behind the last `word` is taken off `text`; nothing if it is not there.
std::optional<std::string> taken_behind(const std::string& word, std::string& text) {
    const auto at = text.rfind(word);
    if (at == std::string::npos || at == 0 || text.find('"', at) != std::string::npos) return std::nullopt;
    const std::string behind = trimmed(text.substr(at + word.size()));
    text = trimmed(text.substr(0, at));
    return behind;
}

std::string take_unit(const std::string& name, Quantity quantity, double& factor) {
    for (const Unit& unit : units_of(quantity))
        if (name == unit.name) {
            factor *= unit.si;
            return {};
        }
    if (quantity == Quantity::number)
        return "is a plain number and has no unit; leave \"in " + name + "\" away";
    return "is a " + std::string(name_of(quantity)) + ", which can't be in \"" + name + "\"" +
           did_you_mean(name, unit_names(quantity), "; its units are " + listing(unit_names(quantity)));
}

/// "column 3"
std::optional<std::size_t> column_number(const std::string& name) {
    if (name.rfind("column ", 0) != 0) return std::nullopt;
    const auto number = number_from_text(trimmed(name.substr(7)));
    if (!number || *number != std::floor(*number) || *number < 1 || *number > 10000) return std::nullopt;
    return static_cast<std::size_t>(*number) - 1;
}

}  // namespace

const std::vector<Unit>& units_of(Quantity quantity) {
    static const std::vector<Unit> time{{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}},
        length{{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"km", 1000}, {"ft", 0.3048}},
        variance{{"m2", 1}, {"cm2", 1e-4}, {"mm2", 1e-6}}, angle{{"rad", rad}, {"deg", deg}},
        turn_rate{{"rad/s", rad}, {"deg/s", deg}},
        speed{{"m/s", 1}, {"km/h", 1 / 3.6}, {"mph", 0.44704}, {"kn", 1852 / 3600.0}, {"mm/s", 0.001}},
        acceleration{{"m/s2", 1}, {"g", gravity_mps2}, {"mg", gravity_mps2 / 1000}}, number;
    switch (quantity) {
        case Quantity::time:
            return time;
        case Quantity::length:
            return length;
        case Quantity::variance:
            return variance;
        case Quantity::angle:
            return angle;
        case Quantity::turn_rate:
            return turn_rate;
        case Quantity::speed:
            return speed;
        case Quantity::acceleration:
            return acceleration;
        case Quantity::number:
            break;
    }
    return number;
}

const char* name_of(Quantity quantity) {
    switch (quantity) {
        case Quantity::time:
            return "time";
        case Quantity::length:
            return "length";
        case Quantity::variance:
            return "variance";
        case Quantity::angle:
            return "angle";
        case Quantity::turn_rate:
            return "turn rate";
        case Quantity::speed:
            return "speed";
        case Quantity::acceleration:
            return "acceleration";
        case Quantity::number:
            break;
    }
    return "number";
}

ParsedColumn column_from_text(const std::string& text, Quantity quantity) {
    ParsedColumn parsed;
    std::string rest = trimmed(text);
    if (const auto times = taken_behind(" times ", rest)) {
        const auto factor = number_from_text(*times);
        if (!factor || *factor == 0) {
            parsed.problem = "has no number but 0 behind \"times\": \"" + *times + "\"";
            return parsed;
        }
        parsed.choice.factor = *factor;
        if (quantity == Quantity::time) parsed.problem = "is a time, which takes no \"times\"; give its unit";
    }
    if (const auto unit = taken_behind(" in ", rest)) {
        if (const auto wrong = take_unit(*unit, quantity, parsed.choice.factor); !wrong.empty())
            parsed.problem = wrong;
    } else if (quantity == Quantity::angle || quantity == Quantity::turn_rate) {
        const auto names = unit_names(quantity);
        parsed.problem = "does not say its unit; write \"" + rest + " in " + names[1] + "\" or \"" + rest +
                         " in " + names[0] + "\"";
    }
    if (rest.size() >= 2 && rest.front() == '"' && rest.back() == '"') rest = rest.substr(1, rest.size() - 2);
    if (rest.empty() && parsed.problem.empty()) parsed.problem = "names no column";
    parsed.choice.number = column_number(rest);
    if (!parsed.choice.number) parsed.choice.name = rest;
    return parsed;
}

std::optional<StampNs> time_from_text(std::string_view text, int power_of_ten) {
    // The decimal point is moved, and the text read as seconds.
    std::string digits(text);
    auto point = digits.find('.');
    if (point == std::string::npos)
        point = digits.size();
    else
        digits.erase(point, 1);
    const bool negative = !digits.empty() && digits[0] == '-';
    const long at = static_cast<long>(point) + power_of_ten, first = negative ? 1 : 0;
    if (at > 30) return std::nullopt;
    if (at < first) digits.insert(static_cast<std::size_t>(first), static_cast<std::size_t>(first - at), '0');
    const auto place = static_cast<std::size_t>(at < first ? first : at);
    if (place > digits.size()) digits.append(place - digits.size(), '0');
    digits.insert(place, 1, '.');
    if (const auto exact = stamp_from_seconds_text(digits)) return exact;
    const auto number = number_from_text(std::string(text));  // "1.5e9"
    const double seconds = number ? *number * std::pow(10.0, power_of_ten) : NAN;
    if (!(std::abs(seconds) < 9e9)) return std::nullopt;
    return static_cast<StampNs>(std::llround(seconds * 1e9));
}

}  // namespace loopline::csv
