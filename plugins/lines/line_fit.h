/// Two least-squares lines: the quick one from running sums, which decides where lines begin and end, and the
/// maximum-likelihood one with its covariance, which is published. Derivation: docs/papers/lines.md.
#pragma once

#include <Eigen/Core>

#include "lines/noise_model.h"
#include "lines/scan_points.h"

namespace loopline::lines {

/// nx x + ny y = rho, with (nx, ny) = (cos alpha, sin alpha) a unit vector and rho >= 0.
struct NormalForm {
    double nx = 1, ny = 0, rho_m = 0;

    double distance_m(double x_m, double y_m) const { return nx * x_m + ny * y_m - rho_m; }
    /// Coordinate along the line, growing with the bearing; 0 at the foot point.
    double along_m(double x_m, double y_m) const { return nx * y_m - ny * x_m; }
};

/// Total least squares, every point alike.
struct QuickFit {
    NormalForm line;
    double across_m2 = 0;  ///< mean square distance from the line
    double along_m2 = 0;   ///< variance of the points along it
};
/// Needs two different points.
QuickFit quick_fit(const Moments& moments);

/// The normal form with the greatest likelihood under the noise model.
struct LikelyFit {
    bool valid = false;
    NormalForm line;
    Eigen::Matrix2d covariance =
        Eigen::Matrix2d::Zero();  ///< of (rho, alpha), for the noise as the model has it
    double chi2 = 0;              ///< of the points in the fit
    double rms_m = 0;
    double autocorrelation = 0;  ///< of the residuals of neighbouring points
    std::size_t count = 0;       ///< points in the fit
    std::size_t first = 0;       ///< outermost of them
    std::size_t last = 0;
};

/// Fits the points of `run` that carry `label` (labels[i] of point i), starting from `start`. Points off by
/// more than three sigma have no part in it, and ends that hang off the line are cut, so that corners and
/// mixed pixels don't drag it. `variance_factor` says by how much residuals exceed the model, for that gate
/// only.
LikelyFit likely_fit(const ScanPoints& points, const Interval& run, const std::vector<int>& labels, int label,
                     const NormalForm& start, const NoiseModel& noise, double variance_factor);

}  // namespace loopline::lines
