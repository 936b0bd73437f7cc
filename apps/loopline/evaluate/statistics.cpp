#include "evaluate/statistics.h"

#include <algorithm>
#include <cmath>

namespace loopline {

Statistics statistics_of(std::vector<double> values) {
    Statistics result;
    result.count = values.size();
    if (values.empty()) return result;
    const auto n = static_cast<double>(values.size());
    double sum = 0, sum_of_squares = 0, sum_about_mean = 0;
    for (const double v : values) sum += v, sum_of_squares += v * v;
    result.mean = sum / n;
    for (const double v : values) sum_about_mean += (v - result.mean) * (v - result.mean);
    result.std_deviation = std::sqrt(sum_about_mean / n);
    result.rmse = std::sqrt(sum_of_squares / n);

    std::sort(values.begin(), values.end());
    result.max = values.back();
    const std::size_t half = values.size() / 2;
    result.median = values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
    return result;
}

}  // namespace loopline
