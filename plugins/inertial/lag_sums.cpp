#include "inertial/lag_sums.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace loopline::inertial {
namespace {

constexpr int narrowest = 5;

/// As wide as the turns are slow: there the correlation hardly falls from one lag to the next, and its noise
/// needs averaging over many.
int half_width_of(const LagSums::Table& correlation, Eigen::Index lag, Eigen::Index axis) {
    constexpr double near_greatest = 0.9;
    const double least = near_greatest * std::abs(correlation(lag, axis));
    int half = narrowest;
    while (lag - half > 0 && lag + half + 1 < LagSums::lags &&
           std::abs(correlation(lag - half, axis)) > least && std::abs(correlation(lag + half, axis)) > least)
        ++half;
    return half;
}

}  // namespace

LagPeak find_peak(const LagSums& sums) {
    LagPeak peak;
    if (sums.n < 2) return peak;
    const LagSums::Table correlation = sums.correlation();
    Eigen::Index lag = 0, axis = 0;
    correlation.abs().maxCoeff(&lag, &axis);
    peak.axis = static_cast<int>(axis);
    peak.cells = static_cast<int>(lag) - LagSums::reach;
    peak.half_width = half_width_of(correlation, lag, axis);
    peak.correlation = correlation.row(lag).transpose();
    if (sums.odometry_squares() > 0)
        peak.slope = (sums.products().row(lag) / sums.odometry_squares()).transpose();
    peak.offset_radps = sums.g.row(lag).transpose().matrix() / sums.n - peak.slope * (sums.r / sums.n);
    return peak;
}

LagParabola parabola_around(int middle, const LagSums& sums, const LagPeak& peak) {
    const int half = std::min(peak.half_width, LagSums::reach - std::abs(middle));
    middle += LagSums::reach;
    const double slope = peak.slope(peak.axis), offset = peak.offset_radps(peak.axis);
    double s0 = 0, s2 = 0, s4 = 0, y0 = 0, y1 = 0, y2 = 0;
    for (int i = -half; i <= half; ++i) {
        // What does not depend on the lag is left out.
        const double y = sums.gg(middle + i, peak.axis) - 2 * slope * sums.rg(middle + i, peak.axis) -
                         2 * offset * sums.g(middle + i, peak.axis);
        const double x = i, xx = x * x;
        s0 += 1;
        s2 += xx;
        s4 += xx * xx;
        y0 += y;
        y1 += x * y;
        y2 += xx * y;
    }
    return {y1 / s2, 2 * (s0 * y2 - s2 * y0) / (s0 * s4 - s2 * s2)};
}

std::optional<int> middle_of_peak(const LagSums& sums, const LagPeak& peak) {
    constexpr int most_steps = 10;
    int middle = peak.cells;
    for (int step = 0; step < most_steps; ++step) {
        if (std::abs(middle) + narrowest > LagSums::reach) return std::nullopt;
        const LagParabola parabola = parabola_around(middle, sums, peak);
        if (parabola.curvature <= 0) return std::nullopt;
        const double shift = std::round(-parabola.slope / parabola.curvature);
        if (std::abs(shift) < 1) return middle;
        if (std::abs(shift) > LagSums::reach) return std::nullopt;
        middle += static_cast<int>(shift);
    }
    return std::nullopt;
}

}  // namespace loopline::inertial
