/// The loops over the beams of a line that is fitted.
#pragma once

#include <cstddef>

#include "lines/noise_model.h"
#include "lines/quick_fit.h"

namespace loopline::lines {

/// d^2 <= gate2 var(d), and the beam says something about the line.
bool lies_on(double x_m, double y_m, const NormalForm& line, const NoiseModel& noise, double gate2);

/// Weighted sums of d = delta_rho - t delta_alpha, and what is reported of the residuals.
struct NormalEquations {
    double w = 0, wt = 0, wtt = 0, wd = 0, wtd = 0, wdd = 0, dd = 0, count = 0;

    NormalEquations operator+(const NormalEquations& o) const {
        return {w + o.w,     wt + o.wt,   wtt + o.wtt, wd + o.wd,
                wtd + o.wtd, wdd + o.wdd, dd + o.dd,   count + o.count};
    }
};

/// Of `size` points, a multiple of `vector_points`, of which those take part that are `counted` by 1 and not
/// by 0 and that lie on the line. Keeps weight and residual of every point, both 0 where it has no part.
NormalEquations normal_equations(const double* x_m, const double* y_m, const double* counted,
                                 std::size_t size, NormalForm line, NoiseModel noise, double gate2,
                                 double* weights, double* residuals_m);

/// Sum of w d d' over neighbours d, d'.
double lagged_squares(const double* weights, const double* residuals_m, std::size_t size);

}  // namespace loopline::lines
