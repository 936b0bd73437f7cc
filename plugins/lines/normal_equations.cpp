#include "lines/normal_equations.h"

#include "lines/vectorised.h"

namespace loopline::lines {
namespace {

// 88.9 degrees: a beam along the wall says nothing about it.
constexpr double max_tan2_incidence = 2500;
constexpr double least_across_m = 1e-9;  // of points behind the sensor, which no beam of the line meets

/// A point as the line has it: residual d, r cos(phi) and r sin(phi).
struct Offset {
    double d_m, across_m, along_m;

    Offset(double x_m, double y_m, const NormalForm& line)
        : across_m(line.nx * x_m + line.ny * y_m), along_m(line.nx * y_m - line.ny * x_m) {
        d_m = across_m - line.rho_m;
    }
};

}  // namespace

bool lies_on(double x_m, double y_m, const NormalForm& line, const NoiseModel& noise, double gate2) {
    // Times r^2 (r cos phi)^2, so that it takes no division; no branch, since all of it is true mostly.
    const Offset p(x_m, y_m, line);
    const double across2 = p.across_m * p.across_m, along2 = p.along_m * p.along_m, rr = across2 + along2;
    const double t_variance_m2 = noise.bearing_variance_rad2 * (line.rho_m * line.rho_m);
    const double scaled_variance =
        (noise.range_variance_m2 * across2 + noise.wall_variance_m2 * rr) * across2 +
        t_variance_m2 * along2 * rr;
    return (p.across_m > 0) & (along2 <= max_tan2_incidence * across2) &
           (p.d_m * p.d_m * across2 * rr <= gate2 * scaled_variance);
}

LOOPLINE_VECTORISED NormalEquations normal_equations(const double* x_m, const double* y_m,
                                                     const double* counted, std::size_t size,
                                                     const NormalForm line, const NoiseModel noise,
                                                     double gate2, double* __restrict weights,
                                                     double* __restrict residuals_m) {
    const double t_variance_m2 = noise.bearing_variance_rad2 * (line.rho_m * line.rho_m);
    double w = 0, wt = 0, wtt = 0, wd = 0, wtd = 0, wdd = 0, dd = 0, count = 0;
    size = size / vector_points * vector_points;
#pragma omp simd reduction(+ : w, wt, wtt, wd, wtd, wdd, dd, count)
    for (std::size_t i = 0; i < size; ++i) {
        const Offset p(x_m[i], y_m[i], line);
        // Where the beam meets the line: t = rho tan(phi), from its direction alone. The measured range is
        // off by the same noise as d, and would bias alpha.
        const double tan = p.along_m / (p.across_m < least_across_m ? least_across_m : p.across_m);
        const double tan2 = tan * tan, inverse_cos2 = 1 + tan2, t_m = line.rho_m * tan;
        const double full_weight =
            inverse_cos2 /
            (noise.range_variance_m2 + (noise.wall_variance_m2 + t_variance_m2 * tan2) * inverse_cos2);
        const double one = counted[i];
        const double within = full_weight * p.d_m * p.d_m <= gate2 ? one : 0;
        const double counts = tan2 <= max_tan2_incidence ? within : 0;

        const double weight = full_weight * counts, d_m = p.d_m * counts;
        w += weight;
        wt += weight * t_m;
        wtt += weight * t_m * t_m;
        wd += weight * d_m;
        wtd += weight * t_m * d_m;
        wdd += weight * d_m * d_m;
        dd += d_m * d_m;
        count += counts;
        weights[i] = weight;
        residuals_m[i] = d_m;
    }
    return {w, wt, wtt, wd, wtd, wdd, dd, count};
}

LOOPLINE_VECTORISED double lagged_squares(const double* weights, const double* residuals_m,
                                          std::size_t size) {
    const std::size_t last = size > 0 ? size - 1 : 0;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (std::size_t i = 0; i < last; ++i) sum += weights[i] * residuals_m[i] * residuals_m[i + 1];
    return sum;
}

}  // namespace loopline::lines
