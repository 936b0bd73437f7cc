/// Gates: quantiles of the normal distribution and of chi-square.
#pragma once

#include <cmath>

namespace loopline::least_squares {

/// Quantile of the standard normal distribution for `probability` in (0.5, 1). Abramowitz and Stegun 26.2.23;
/// error below 5e-4.
inline double normal_quantile(double probability) {
    const double t = std::sqrt(-2 * std::log(1 - probability));
    return t -
           (2.515517 + t * (0.802853 + t * 0.010328)) / (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

/// Quantile of chi-square. Exact for one and two degrees of freedom but for the above; within 2 % for more,
/// by Wilson and Hilferty 1931.
inline double chi_square_quantile(double degrees_of_freedom, double probability) {
    if (degrees_of_freedom == 1) {
        const double z = normal_quantile((1 + probability) / 2);
        return z * z;
    }
    if (degrees_of_freedom == 2) return -2 * std::log(1 - probability);
    const double h = 2 / (9 * degrees_of_freedom), z = normal_quantile(probability);
    return degrees_of_freedom * std::pow(1 - h + z * std::sqrt(h), 3);
}

}  // namespace loopline::least_squares
