/// Round numbers and lengths for scale bars and axes.
#pragma once

#include <string>
#include <vector>

namespace loopline {

/// The largest of 1, 2, 5 times a power of ten that is not above `limit` (> 0).
double round_number_below(double limit);

/// "20 cm", "5 m", "2 km".
std::string length_text(double length_m);

/// `value` with as many decimals as multiples of `step` need, with a true minus sign.
std::string tick_text(double value, double step);

/// Multiples of a round step within [low, high], at most `most` (>= 2) of them; `step` receives the step.
std::vector<double> ticks(double low, double high, int most, double& step);

/// "40 213", with narrow spaces.
std::string grouped(std::size_t count);

}  // namespace loopline
