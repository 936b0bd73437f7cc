#include "lines/noise_model.h"

#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {
constexpr double default_sigma_range_m = 0.01;
constexpr double median_of_chi2_1 = 0.4549364;
constexpr double max_noise_factor = 36;  // six times the stated sigma: beyond that it is clutter, not noise
constexpr std::size_t min_triples = 20;
constexpr double smallest_variance_m2 = 1e-14;
}  // namespace

NoiseModel stated_noise(const ExtractionParameters& parameters, double scan_sigma_range_m) {
    double sigma_range_m = parameters.sigma_range_m;
    if (!(sigma_range_m > 0)) sigma_range_m = scan_sigma_range_m;
    if (!(sigma_range_m > 0)) sigma_range_m = default_sigma_range_m;
    return {sigma_range_m * sigma_range_m, parameters.sigma_bearing_rad * parameters.sigma_bearing_rad,
            parameters.sigma_wall_m * parameters.sigma_wall_m};
}

double measured_noise_factor(const ScanPoints& points, const NoiseModel& noise,
                             std::vector<double>& scratch) {
    scratch.clear();
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const ScanPoint &a = points[i - 1], &p = points[i], &b = points[i + 1];
        if (b.beam - a.beam != 2) continue;
        const double ux = b.x_m - a.x_m, uy = b.y_m - a.y_m;
        const double chord2 = ux * ux + uy * uy;
        // Distance of p from the chord; its variance is that of p plus half that of a and b.
        const double cross = ux * (p.y_m - a.y_m) - uy * (p.x_m - a.x_m);
        const double through = a.x_m * b.y_m - a.y_m * b.x_m;
        const double cos2_incidence = std::min(1.0, through * through / (chord2 * p.range_m * p.range_m));
        const double t2 = p.range_m * p.range_m * (1 - cos2_incidence);
        const double expected = 1.5 * (noise.range_variance_m2 * cos2_incidence +
                                       noise.bearing_variance_rad2 * t2 + noise.wall_variance_m2);
        if (chord2 > 0)
            scratch.push_back(cross * cross / (chord2 * std::max(expected, smallest_variance_m2)));
    }
    if (scratch.size() < min_triples) return 1;
    const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() / 2);
    std::nth_element(scratch.begin(), middle, scratch.end());
    const double factor = *middle / median_of_chi2_1;
    // The estimate itself scatters by about 2.4 / sqrt(n): below three times that it says nothing, from a
    // third more on it is believed fully.
    const double doubt = 1 + 7.2 / std::sqrt(static_cast<double>(scratch.size()));
    if (!(factor > doubt)) return 1;
    const double sure = 4.0 / 3.0 * doubt;
    const double believed = factor < sure ? 1 + (sure - 1) * (factor - doubt) / (sure - doubt) : factor;
    return std::min(believed, max_noise_factor);
}

}  // namespace loopline::lines
