#include "lines/straightness.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lines/vectorised.h"

namespace loopline::lines {
namespace {

constexpr double z_limit = 3.09;  // one-sided, 0.1 %
constexpr double bend_sigmas = 3;
constexpr double max_disorder_factor = 25;   // in variance, over the model
constexpr double max_disorder_ratio = 0.02;  // rms over length
constexpr double least_disorder = 0.75;
constexpr std::size_t most_tabulated = 2048;  // degrees of freedom

double wilson_hilferty(double degrees_of_freedom) {
    const double v = 2 / (9 * degrees_of_freedom);
    const double root = 1 - v + z_limit * std::sqrt(v);
    return root * root * root;
}

}  // namespace

double chi2_per_degree_limit(std::size_t degrees_of_freedom) {
    static const std::vector<double> limits = [] {
        std::vector<double> values(most_tabulated);
        for (std::size_t i = 1; i < values.size(); ++i) values[i] = wilson_hilferty(static_cast<double>(i));
        return values;
    }();
    return degrees_of_freedom < limits.size() ? limits[degrees_of_freedom]
                                              : wilson_hilferty(static_cast<double>(degrees_of_freedom));
}

namespace {

/// Of the mean square of n residuals of unit variance about their line.
double straight_limit(std::size_t n) {
    return chi2_per_degree_limit(n - 2) * static_cast<double>(n - 2) / static_cast<double>(n);
}

/// Von Neumann's ratio: half the mean square step from one residual to the next, over their mean square. 1
/// for noise, 2 for teeth, near 0 for corners, steps and bends.
LOOPLINE_VECTORISED double disorder(const ScanPoints& points, const Interval& run, const QuickFit& fit) {
    const double *const x_m = points.x_m() + run.begin, *const y_m = points.y_m() + run.begin;
    const double nx = fit.line.nx, ny = fit.line.ny;
    const std::size_t size = run.size() - 1;
    double steps = 0;
#pragma omp simd reduction(+ : steps)
    for (std::size_t i = 0; i < size; ++i) {
        const double step_m = nx * (x_m[i + 1] - x_m[i]) + ny * (y_m[i + 1] - y_m[i]);
        steps += step_m * step_m;
    }
    return steps / (2 * static_cast<double>(size) * fit.across_m2);
}

}  // namespace

Straightness straightness(const ScanPoints& points, const Interval& run, const NoiseModel& noise,
                          double max_bow) {
    const Moments all = points.moments(run);
    Straightness result;
    result.fit = quick_fit(all);
    result.variance_m2 = noise.mean_variance_m2(all, result.fit);
    const double n = all.n, scatter_m2 = result.fit.across_m2;
    const double squared_length_m2 = 12 * result.fit.along_m2;
    const double limit = straight_limit(run.size());
    double variance_m2 = result.variance_m2;
    if (scatter_m2 > limit * variance_m2 && scatter_m2 < max_disorder_factor * variance_m2 &&
        scatter_m2 < max_disorder_ratio * max_disorder_ratio * squared_length_m2 &&
        disorder(points, run, result.fit) > least_disorder)
        variance_m2 = scatter_m2;

    // A parabola of sagitta s lies (s/4) further out in its middle half than the line, and (s/4) further in
    // at the quarters beside; the mean square of its residuals is (4/45) s^2. The contrast of those means has
    // variance 4/n.
    const std::size_t quarter = run.size() / 4;
    const Moments middle = points.moments({run.begin + quarter, run.end - quarter});
    const double outer_n = n - middle.n;
    if (outer_n > 0) {
        // From the difference of the means, (middle / n_middle - outer / n_outer).
        const double inverse = 1 / (middle.n * outer_n);
        const double dx_m = (middle.x * n - all.x * middle.n) * inverse;
        const double dy_m = (middle.y * n - all.y * middle.n) * inverse;
        result.sagitta_m = 2 * (result.fit.line.nx * dx_m + result.fit.line.ny * dy_m);
        result.sigma_sagitta_m = 2 * std::sqrt(variance_m2 * n * inverse);
    }
    const double bow_m = max_bow * std::sqrt(squared_length_m2);
    const double parabola_m2 = 4.0 / 45.0;
    const bool bent = std::abs(result.sagitta_m) > bow_m + bend_sigmas * result.sigma_sagitta_m;
    const bool scattered = scatter_m2 > limit * variance_m2 + parabola_m2 * bow_m * bow_m;
    result.shape = bent ? Shape::bent : scattered ? Shape::broken : Shape::straight;
    return result;
}

LOOPLINE_VECTORISED double squares_left_by_parabola_m2(const ScanPoints& points, const Interval& run,
                                                       const NormalForm& line_of_run) {
    const NormalForm line = line_of_run;
    const double *const x_m = points.x_m(), *const y_m = points.y_m();
    // Polynomials 1, t, t^2 made orthogonal over the points, with t from about their middle.
    const double centre_t =
        line.along_m(0.5 * (x_m[run.begin] + x_m[run.end - 1]), 0.5 * (y_m[run.begin] + y_m[run.end - 1]));
    double t1 = 0, t2 = 0, t3 = 0, t4 = 0, d0 = 0, d1 = 0, d2 = 0, dd = 0;
#pragma omp simd reduction(+ : t1, t2, t3, t4, d0, d1, d2, dd)
    for (std::size_t i = run.begin; i < run.end; ++i) {
        const double t = line.along_m(x_m[i], y_m[i]) - centre_t, tt = t * t;
        const double d = line.distance_m(x_m[i], y_m[i]);
        t1 += t;
        t2 += tt;
        t3 += tt * t;
        t4 += tt * tt;
        d0 += d;
        d1 += d * t;
        d2 += d * tt;
        dd += d * d;
    }
    const double n = static_cast<double>(run.size());
    const double spread1 = t2 - t1 * t1 / n;
    if (!(spread1 > 0)) return dd;
    const double skew = (t3 - t1 * t2 / n) / spread1;
    const double spread2 = t4 - t2 * t2 / n - skew * skew * spread1;
    const double along1 = d1 - d0 * t1 / n, along2 = d2 - d0 * t2 / n - skew * along1;
    const double left = dd - d0 * d0 / n - along1 * along1 / spread1;
    return std::max(0.0, spread2 > 1e-12 * t4 ? left - along2 * along2 / spread2 : left);
}

}  // namespace loopline::lines
