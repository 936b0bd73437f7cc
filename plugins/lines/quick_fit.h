/// The least-squares line of a set of points from their moments: the quick fit, which decides where lines
/// begin and end.
#pragma once

#include <algorithm>
#include <cmath>

#include "lines/scan_points.h"

namespace loopline::lines {

/// nx x + ny y = rho, with (nx, ny) = (cos alpha, sin alpha) a unit vector and rho >= 0.
struct NormalForm {
    double nx = 1, ny = 0, rho_m = 0;

    double distance_m(double x_m, double y_m) const { return nx * x_m + ny * y_m - rho_m; }
    /// Coordinate along the line, growing with the bearing; 0 at the foot point.
    double along_m(double x_m, double y_m) const { return nx * y_m - ny * x_m; }
};

/// x, or 0 where it is negative.
inline double positive(double x) {
    return x > 0 ? x : 0;
}

constexpr double least_spread_m2 = 1e-300;  // of points that are one

/// Mean of points, and their variances along and across the direction a in which they spread most.
struct PrincipalAxes {
    double mean_x_m = 0, mean_y_m = 0;
    double along_m2 = 0, across_m2 = 0;
    double cos_2a = 1, sin_2a = 0;  ///< of twice the direction a

    /// Squared distance of the line along a through the mean.
    double squared_rho_m2() const {
        const double xx = mean_x_m * mean_x_m, yy = mean_y_m * mean_y_m;
        return 0.5 * (xx + yy - cos_2a * (xx - yy)) - sin_2a * mean_x_m * mean_y_m;
    }
};

inline PrincipalAxes principal_axes(const Moments& m) {
    const double inverse_n = 1 / m.n;
    PrincipalAxes axes;
    axes.mean_x_m = m.x * inverse_n;
    axes.mean_y_m = m.y * inverse_n;
    const double sxx = m.xx * inverse_n - axes.mean_x_m * axes.mean_x_m;
    const double syy = m.yy * inverse_n - axes.mean_y_m * axes.mean_y_m;
    const double twice_sxy = 2 * (m.xy * inverse_n - axes.mean_x_m * axes.mean_y_m);
    const double difference = sxx - syy;
    const double spread = std::sqrt(difference * difference + twice_sxy * twice_sxy);
    axes.along_m2 = positive(0.5 * (sxx + syy + spread));
    axes.across_m2 = positive(0.5 * (sxx + syy - spread));
    const double inverse_spread = 1 / (spread + least_spread_m2);
    axes.cos_2a = difference * inverse_spread;
    axes.sin_2a = twice_sxy * inverse_spread;
    return axes;
}

/// Total least squares, every point alike. `across_m2` is the mean square distance from the line.
struct QuickFit : PrincipalAxes {
    NormalForm line;
};

/// Needs two different points.
inline QuickFit quick_fit(const Moments& m) {
    QuickFit fit{principal_axes(m), {}};
    // Half the angle, from that of its sine and cosine which is not small. No branch: which it is can't be
    // predicted.
    const double larger = std::sqrt(0.5 + 0.5 * std::abs(fit.cos_2a)), smaller = 0.5 * fit.sin_2a / larger;
    const double along_x = 0.5 + std::copysign(0.5, fit.cos_2a), along_y = 1 - along_x;
    const double cos_a = along_x * larger + along_y * smaller;
    const double sin_a = along_x * smaller + along_y * larger;
    const double offset_m = cos_a * fit.mean_y_m - sin_a * fit.mean_x_m;
    const double side = std::copysign(1.0, offset_m);
    fit.line = {-side * sin_a, side * cos_a, side * offset_m};
    return fit;
}

}  // namespace loopline::lines
