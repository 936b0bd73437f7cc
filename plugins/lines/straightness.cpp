#include "lines/straightness.h"

#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {

constexpr double z_limit = 3.09;  // one-sided, 0.1 %
constexpr double bend_sigmas = 3;
constexpr double max_disorder_factor = 25;   // in variance, over the model
constexpr double max_disorder_ratio = 0.02;  // rms over length
constexpr double least_disorder = 0.75;

double mean_distance_m(const NormalForm& line, const Moments& m) {
    return (line.nx * m.x + line.ny * m.y) / m.n - line.rho_m;
}

/// Von Neumann's ratio: half the mean square step from one residual to the next, over their mean square. 1
/// for noise, 2 for teeth, near 0 for corners, steps and bends.
double disorder(const ScanPoints& points, const Interval& run, const QuickFit& fit) {
    double previous = fit.line.distance_m(points[run.begin].x_m, points[run.begin].y_m), steps = 0;
    for (std::size_t i = run.begin + 1; i < run.end; ++i) {
        const double d = fit.line.distance_m(points[i].x_m, points[i].y_m);
        steps += (d - previous) * (d - previous);
        previous = d;
    }
    return steps / (2 * static_cast<double>(run.size() - 1) * fit.across_m2);
}

}  // namespace

double chi2_per_degree_limit(double degrees_of_freedom) {
    const double v = 2 / (9 * degrees_of_freedom);
    const double root = 1 - v + z_limit * std::sqrt(v);
    return root * root * root;
}

Straightness straightness(const ScanPoints& points, const Interval& run, const NoiseModel& noise,
                          double max_bow) {
    Straightness result;
    const Moments all = points.moments(run);
    const double n = all.n;
    result.fit = quick_fit(all);
    double variance_m2 = noise.mean_variance_m2(all, result.fit.line.rho_m);
    const double length_m = std::sqrt(12 * result.fit.along_m2);
    const double limit = chi2_per_degree_limit(n - 2) * (n - 2) / n;
    const double scatter_m2 = result.fit.across_m2;
    if (scatter_m2 > limit * variance_m2 && scatter_m2 < max_disorder_factor * variance_m2 &&
        scatter_m2 < max_disorder_ratio * max_disorder_ratio * length_m * length_m &&
        disorder(points, run, result.fit) > least_disorder)
        variance_m2 = scatter_m2;

    // A parabola of sagitta s lies (s/4) further out in its middle half than the line, and (s/4) further in
    // at the quarters beside; the mean square of its residuals is (4/45) s^2. The contrast of those means has
    // variance 4/n.
    if (run.size() >= 4) {
        const std::size_t quarter = run.size() / 4;
        const Moments middle = points.moments({run.begin + quarter, run.end - quarter});
        const Moments outer = all - middle;
        const double contrast_m =
            mean_distance_m(result.fit.line, middle) - mean_distance_m(result.fit.line, outer);
        result.sagitta_m = 2 * contrast_m;
        result.sigma_sagitta_m = 2 * std::sqrt(variance_m2 * (1 / middle.n + 1 / outer.n));
    }
    const double bow_m = max_bow * length_m;
    const double parabola_m2 = 4.0 / 45.0;
    const bool bent = std::abs(result.sagitta_m) > bow_m + bend_sigmas * result.sigma_sagitta_m;
    if (!bent && result.fit.across_m2 <= limit * variance_m2 + parabola_m2 * bow_m * bow_m) {
        result.shape = Shape::straight;
    } else if (bent) {
        result.shape = Shape::bent;
    }
    return result;
}

double squares_left_by_parabola_m2(const ScanPoints& points, const Interval& run, const NormalForm& line) {
    // Polynomials 1, t, t^2 made orthogonal over the points, with t from about their middle.
    const double centre_t = line.along_m(0.5 * (points[run.begin].x_m + points[run.end - 1].x_m),
                                         0.5 * (points[run.begin].y_m + points[run.end - 1].y_m));
    double t1 = 0, t2 = 0, t3 = 0, t4 = 0, d0 = 0, d1 = 0, d2 = 0, dd = 0;
    for (std::size_t i = run.begin; i < run.end; ++i) {
        const double t = line.along_m(points[i].x_m, points[i].y_m) - centre_t, tt = t * t;
        const double d = line.distance_m(points[i].x_m, points[i].y_m);
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
