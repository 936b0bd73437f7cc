/// Gates: the quantile of chi-square.
#pragma once

#include <cmath>

namespace loopline::inertial {

/// Abramowitz and Stegun 26.2.23 for the normal quantile (probability in (0.5, 1)), Wilson and Hilferty 1931
/// from it; within 2 % of the exact value at the probabilities that gates use.
inline double chi_square_quantile(int degrees_of_freedom, double probability) {
    const double t = std::sqrt(-2 * std::log(1 - probability));
    const double z =
        t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    const double h = 2 / (9.0 * degrees_of_freedom);
    return degrees_of_freedom * std::pow(1 - h + z * std::sqrt(h), 3);
}

}  // namespace loopline::inertial
