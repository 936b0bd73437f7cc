#include "api/parameters.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <locale>
#include <sstream>

namespace loopline {
namespace {

std::string unit_of(const std::string& name) {
    for (const char* unit : {"m", "s", "deg", "hz", "mps", "mps2", "dps", "ms", "mb"}) {
        const std::string suffix = std::string("_") + unit;
        if (name.size() > suffix.size() &&
            name.compare(name.size() - suffix.size(), suffix.size(), suffix) == 0)
            return unit;
    }
    return {};
}

/// A whole number without an exponent: 2000000000, not 2e+09.
std::string bound_text(double bound) {
    if (bound != std::floor(bound) || std::abs(bound) > 1e15) return number_text(bound);
    return std::to_string(static_cast<std::int64_t>(bound));
}

std::string range_text(const Range& range) {
    const bool from = std::isfinite(range.min), to = std::isfinite(range.max);
    const bool above_zero = range.min > 0 && range.min < 1e-300;
    if (above_zero && !to) return "> 0";
    if (from && to) return bound_text(above_zero ? 0 : range.min) + " .. " + bound_text(range.max);
    if (from) return ">= " + bound_text(range.min);
    if (to) return "<= " + bound_text(range.max);
    return {};
}

std::optional<std::string> outside(double value, const Range& range) {
    if (value >= range.min && value <= range.max) return std::nullopt;
    return "is out of range (allowed: " + range_text(range) + ")";
}

std::string join(const std::vector<std::string>& parts, const std::string& separator) {
    std::string text;
    for (const auto& part : parts) text += (text.empty() ? "" : separator) + part;
    return text;
}

/// Degrees as they are printed. Radians and back may cost the last digits: twelve count.
std::string degrees_text(double degrees) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.precision(12);
    text << degrees;
    return text.str();
}

/// The radians that the printed degrees read back as.
double printable_radians(double degrees) {
    return *number_from_text(degrees_text(degrees)) * M_PI / 180;
}

}  // namespace

std::string number_text(double value) {
    std::array<char, 64> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
    return {text.data(), end.ptr};
}

std::optional<double> number_from_text(const std::string& text) {
    double value = 0;
    const char* begin = text.data() + (text.rfind('+', 0) == 0 ? 1 : 0);
    const auto end = std::from_chars(begin, text.data() + text.size(), value);
    if (end.ec != std::errc() || end.ptr != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::vector<std::string> split_words(const std::string& text, const std::string& separators) {
    std::vector<std::string> parts;
    std::size_t begin = 0;
    while (begin <= text.size()) {
        const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
        const std::size_t first = text.find_first_not_of(" \t", begin);
        if (first < end) {
            const std::size_t last = text.find_last_not_of(" \t", end - 1);
            parts.push_back(text.substr(first, last - first + 1));
        }
        begin = end + 1;
    }
    return parts;
}

ParameterTable& ParameterTable::add(Parameter parameter) {
    assert(!find(parameter.name) && "a key is declared once");
    parameter.unit = unit_of(parameter.name);
    parameter.default_text = parameter.print();
    parameters_.push_back(std::move(parameter));
    return *this;
}

const Parameter* ParameterTable::find(const std::string& name) const {
    for (const auto& p : parameters_)
        if (p.name == name) return &p;
    return nullptr;
}

ParameterTable& ParameterTable::real(const std::string& name, double& value, Range range,
                                     const std::string& sentence) {
    const auto parse = [&value, range](const std::string& text) -> std::optional<std::string> {
        const auto number = number_from_text(text);
        if (!number) return "is not a number: \"" + text + "\"";
        if (auto problem = outside(*number, range)) return problem;
        value = *number;
        return std::nullopt;
    };
    return add({name, ParameterKind::real, {}, range_text(range), sentence, {}, parse, [&value] {
                    return number_text(value);
                }});
}

ParameterTable& ParameterTable::angle(const std::string& name, double& value_rad, Range range_deg,
                                      const std::string& sentence) {
    value_rad = printable_radians(value_rad * 180 / M_PI);
    const auto parse = [&value_rad, range_deg](const std::string& text) -> std::optional<std::string> {
        const auto degrees = number_from_text(text);
        if (!degrees) return "is not a number: \"" + text + "\"";
        if (auto problem = outside(*degrees, range_deg)) return problem;
        value_rad = printable_radians(*degrees);
        return std::nullopt;
    };
    return add({name, ParameterKind::real, {}, range_text(range_deg), sentence, {}, parse, [&value_rad] {
                    return degrees_text(value_rad * 180 / M_PI);
                }});
}

ParameterTable& ParameterTable::integer(const std::string& name, int& value, Range range,
                                        const std::string& sentence) {
    const auto parse = [&value, range](const std::string& text) -> std::optional<std::string> {
        int number = 0;
        const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
        if (end.ec != std::errc() || end.ptr != text.data() + text.size())
            return "is not a whole number: \"" + text + "\"";
        if (auto problem = outside(number, range)) return problem;
        value = number;
        return std::nullopt;
    };
    return add({name, ParameterKind::integer, {}, range_text(range), sentence, {}, parse, [&value] {
                    return std::to_string(value);
                }});
}

ParameterTable& ParameterTable::seed(const std::string& name, std::uint64_t& value,
                                     const std::string& sentence) {
    const auto parse = [&value](const std::string& text) -> std::optional<std::string> {
        std::uint64_t number = 0;
        const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
        if (end.ec != std::errc() || end.ptr != text.data() + text.size())
            return "is not a whole number of at least 0: \"" + text + "\"";
        value = number;
        return std::nullopt;
    };
    return add({name, ParameterKind::integer, {}, ">= 0", sentence, {}, parse, [&value] {
                    return std::to_string(value);
                }});
}

ParameterTable& ParameterTable::boolean(const std::string& name, bool& value, const std::string& sentence) {
    const auto parse = [&value](const std::string& text) -> std::optional<std::string> {
        if (text == "true" || text == "yes" || text == "on" || text == "1")
            value = true;
        else if (text == "false" || text == "no" || text == "off" || text == "0")
            value = false;
        else
            return "is neither true nor false: \"" + text + "\"";
        return std::nullopt;
    };
    return add(
        {name, ParameterKind::boolean, {}, "true | false", sentence, {}, parse, [&value]() -> std::string {
             return value ? "true" : "false";
         }});
}

ParameterTable& ParameterTable::text(const std::string& name, std::string& value,
                                     const std::string& sentence) {
    const auto parse = [&value](const std::string& text) -> std::optional<std::string> {
        value = text;
        return std::nullopt;
    };
    return add({name, ParameterKind::text, {}, {}, sentence, {}, parse, [&value] { return value; }});
}

ParameterTable& ParameterTable::path(const std::string& name, std::string& value, const std::string& sentence,
                                     FileNeed need) {
    text(name, value, sentence);
    parameters_.back().kind = ParameterKind::path;
    parameters_.back().need = need;
    return *this;
}

ParameterTable& ParameterTable::add_words(const std::string& name, ParameterKind kind,
                                          std::vector<std::string>& value, const std::string& separators,
                                          const std::string& joint, const std::string& sentence) {
    const auto parse = [&value, separators](const std::string& text) -> std::optional<std::string> {
        value = split_words(text, separators);
        return std::nullopt;
    };
    return add({name, kind, {}, {}, sentence, {}, parse, [&value, joint] { return join(value, joint); }});
}

ParameterTable& ParameterTable::list(const std::string& name, std::vector<std::string>& value,
                                     const std::string& sentence) {
    return add_words(name, ParameterKind::list, value, " \t,", " ", sentence);
}

ParameterTable& ParameterTable::paths(const std::string& name, std::vector<std::string>& value,
                                      const std::string& sentence, FileNeed need) {
    add_words(name, ParameterKind::path_list, value, ";", "; ", sentence);
    parameters_.back().need = need;
    return *this;
}

ParameterTable& ParameterTable::rows(const std::string& name, std::vector<std::vector<double>>& value,
                                     RowShape shape, const std::string& form, const std::string& sentence) {
    const auto parse = [&value, shape, form](const std::string& text) -> std::optional<std::string> {
        std::vector<double> row;
        for (const auto& word : split_words(text, " \t,")) {
            const auto number = number_from_text(word);
            if (!number) return "holds \"" + word + "\", which is not a number";
            row.push_back(*number);
        }
        const bool enough = row.size() >= shape.first;
        const std::size_t beyond = enough ? row.size() - shape.first : 0;
        if (!enough || (shape.more == 0 ? beyond != 0 : beyond % shape.more != 0))
            return "has " + std::to_string(row.size()) + " numbers (needed: " + form + ")";
        value.push_back(std::move(row));
        return std::nullopt;
    };
    const auto print_rows = [&value] {
        std::vector<std::string> texts;
        for (const auto& row : value) {
            std::vector<std::string> numbers;
            for (const double number : row) numbers.push_back(number_text(number));
            texts.push_back(join(numbers, " "));
        }
        return texts;
    };
    add({name, ParameterKind::rows, {}, form, sentence, {}, parse, [] { return std::string(); }});
    parameters_.back().print_rows = print_rows;
    return *this;
}

ParameterTable& ParameterTable::add_choice(const std::string& name, const std::vector<std::string>& names,
                                           std::function<void(std::size_t)> set,
                                           std::function<std::size_t()> get, const std::string& sentence) {
    const std::string allowed = join(names, " | ");
    const auto parse = [names, set, allowed](const std::string& text) -> std::optional<std::string> {
        for (std::size_t i = 0; i < names.size(); ++i)
            if (names[i] == text) {
                set(i);
                return std::nullopt;
            }
        return "is not one of " + allowed + ": \"" + text + "\"";
    };
    return add({name,
                ParameterKind::choice,
                {},
                allowed,
                sentence,
                {},
                parse,
                [names, get] { return names[get()]; },
                names});
}

}  // namespace loopline
