/// Round numbers are 1, 2 and 5 times powers of ten.
#include "render/scale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace loopline {
namespace {

std::string decimal(double value, int decimals) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    for (char& c : text)
        if (c == ',') c = '.';
    return text;
}

}  // namespace

double round_number_below(double limit) {
    const double power = std::pow(10, std::floor(std::log10(limit)));
    constexpr double rounding = 1 - 1e-9;  // 0.1 + 0.2 may stand for 0.3
    for (const double factor : {10., 5., 2.})
        if (factor * power * rounding <= limit) return factor * power;
    return power;
}

std::string length_text(double length_m) {
    const auto trimmed = [](double value) {
        char text[32];
        std::snprintf(text, sizeof text, "%.6g", value);
        return std::string(text);
    };
    if (length_m >= 1000) return trimmed(length_m / 1000) + " km";
    if (length_m < 0.01) return trimmed(length_m * 1000) + " mm";
    if (length_m < 1) return trimmed(length_m * 100) + " cm";
    return trimmed(length_m) + " m";
}

std::string tick_text(double value, double step) {
    const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
    const bool is_zero = std::abs(value) < step / 2;
    return (value < 0 && !is_zero ? "\u2212" : "") + decimal(is_zero ? 0 : std::abs(value), decimals);
}

std::vector<double> ticks(double low, double high, int most, double& step) {
    const double span = high - low;
    step = 1;
    if (!(span > 0) || !std::isfinite(span)) return {low};
    // The smallest round step that does not give too many.
    step = round_number_below(span);
    while (span / round_number_below(step * 0.55) <= most - 1) step = round_number_below(step * 0.55);
    while (span / step > most - 1) step = round_number_below(step * 2.6);
    std::vector<double> values;
    for (double k = std::ceil(low / step - 1e-9); k <= std::floor(high / step + 1e-9); ++k)
        values.push_back(k * step);
    return values;
}

std::string grouped(std::size_t count) {
    std::string digits = std::to_string(count);
    for (int i = static_cast<int>(digits.size()) - 3; i > 0; i -= 3) digits.insert(i, "\u202f");
    return digits;
}

}  // namespace loopline
