/// How far a return may lie from the wall that it comes from. The residual of a beam with incidence angle phi
/// on a line (rho, alpha) is d = r cos(phi) - rho, phi = bearing - alpha. Range noise e moves it by e
/// cos(phi), a beam that points off by b moves it by b t with t = rho tan(phi) the hit's place along the
/// wall, and unevenness u of the wall moves it by u itself:
///
///     var(d) = sigma_range^2 cos^2(phi) + sigma_bearing^2 t^2 + sigma_wall^2
#pragma once

#include <vector>

#include "lines/extraction_parameters.h"
#include "lines/quick_fit.h"

namespace loopline::lines {

struct NoiseModel {
    double range_variance_m2 = 0;
    double bearing_variance_rad2 = 0;
    double wall_variance_m2 = 0;
    double factor = 1;  ///< of all of them, over what is stated

    double variance_m2(double cos2_incidence, double t_m) const {
        return range_variance_m2 * cos2_incidence + bearing_variance_rad2 * t_m * t_m + wall_variance_m2;
    }
    /// Mean of var(d) over points with these moments and axes, on their least-squares line: the mean of
    /// cos^2(phi) follows from the sums over the beams' bearings, that of t^2 from those over the points.
    double mean_variance_m2(const Moments& m, const PrincipalAxes& axes) const {
        const double inverse_n = 1 / m.n;
        // The normal has a direction of a + pi/2.
        const double mean_cos2 = 0.5 - 0.5 * inverse_n * (axes.cos_2a * m.cos2 + axes.sin_2a * m.sin2);
        const double mean_tt = (m.xx + m.yy) * inverse_n - axes.squared_rho_m2();
        return range_variance_m2 * mean_cos2 + bearing_variance_rad2 * positive(mean_tt) + wall_variance_m2;
    }
    void scale(double by) {
        range_variance_m2 *= by;
        bearing_variance_rad2 *= by;
        wall_variance_m2 *= by;
        factor *= by;
    }
};

/// The stated noise: of the parameters, or of the scan where they leave it open, 1 cm where neither says.
NoiseModel stated_noise(const ExtractionParameters& parameters, double scan_sigma_range_m);

/// By how much a scan's own scatter about lines exceeds the model's variances. A stated noise that is too low
/// would break every wall into pieces, and it often is: logs carry default values, noise grows with range,
/// and walls in simulated worlds may be stairs of grid cells.
///
/// Every stretch of about a metre within runs without gaps has its least-squares line and the mean square of
/// its residuals. Corners and clutter raise some of these; noise and rough walls raise them all. So a low
/// quantile of them is compared with what it would be for the model.
class NoiseMeter {
 public:
    static constexpr std::size_t min_points = 8;  ///< of a stretch

    /// 1 if the noise doesn't clearly exceed the model. Keeps working memory.
    double factor(const ScanPoints& points, const std::vector<Interval>& runs, const NoiseModel& noise);

 private:
    void tabulate_quantiles(std::size_t points);

    std::vector<double> quantiles_;  ///< index n: of the mean square of n unit residuals about their line
    std::vector<double> ratios_;     ///< of the stretches
};

}  // namespace loopline::lines
