#include "inertial/lag_sums.h"

#include <cmath>

namespace loopline::inertial {

LagPeak find_peak(const LagSums& sums) {
    LagPeak peak;
    if (sums.n < 2) return peak;
    const LagSums::Table correlation = sums.correlation();
    Eigen::Index lag = 0, axis = 0;
    correlation.abs().maxCoeff(&lag, &axis);
    peak.axis = static_cast<int>(axis);
    peak.cells = static_cast<int>(lag) - LagSums::reach;
    peak.correlation = correlation.row(lag).transpose();
    if (sums.odometry_squares() > 0)
        peak.slope = (sums.products().row(lag) / sums.odometry_squares()).transpose();
    peak.offset_radps = sums.g.row(lag).transpose().matrix() / sums.n - peak.slope * (sums.r / sums.n);
    return peak;
}

std::optional<LagParabola> parabola_at_peak(const LagSums& sums, const LagPeak& peak) {
    // Narrow against the time that a vehicle's turn takes, wide against the noise from one lag to the next.
    constexpr int half = 5;
    const int middle = peak.cells + LagSums::reach;
    if (middle < half || middle + half >= LagSums::lags) return std::nullopt;
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
    return LagParabola{y1 / s2, 2 * (s0 * y2 - s2 * y0) / (s0 * s4 - s2 * s2)};
}

}  // namespace loopline::inertial
