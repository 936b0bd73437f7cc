#include "lines/noise_model.h"

#include <algorithm>
#include <cmath>

#include "lines/line_fit.h"

namespace loopline::lines {
namespace {
constexpr double default_sigma_range_m = 0.01;
constexpr double max_noise_factor = 36;  // six times the stated sigma: beyond that it is clutter, not noise
constexpr double stretch_m = 1;
constexpr std::size_t min_stretch_points = 8, min_stretches = 4;
constexpr double quantile = 0.4, z_of_quantile = -0.2533;
}  // namespace

NoiseModel stated_noise(const ExtractionParameters& parameters, double scan_sigma_range_m) {
    double sigma_range_m = parameters.sigma_range_m;
    if (!(sigma_range_m > 0)) sigma_range_m = scan_sigma_range_m;
    if (!(sigma_range_m > 0)) sigma_range_m = default_sigma_range_m;
    return {sigma_range_m * sigma_range_m, parameters.sigma_bearing_rad * parameters.sigma_bearing_rad,
            parameters.sigma_wall_m * parameters.sigma_wall_m,
            parameters.beam_width_rad * parameters.beam_width_rad / 4};
}

double measured_noise_factor(const ScanPoints& points, const std::vector<Interval>& runs,
                             const NoiseModel& noise, std::vector<double>& scratch) {
    scratch.clear();
    for (const Interval& run : runs) {
        std::size_t begin = run.begin;
        while (begin + min_stretch_points <= run.end) {
            std::size_t end = begin + min_stretch_points;
            while (end < run.end && points.squared_distance_m2(begin, end - 1) < stretch_m * stretch_m) ++end;
            const Moments moments = points.moments({begin, end});
            const QuickFit fit = quick_fit(moments);
            const double degrees = moments.n - 2;
            const double variance_m2 = noise.mean_variance_m2(moments, fit.line.rho_m);
            // Wilson and Hilferty: the quantile of chi-square per degree of freedom.
            const double v = 2 / (9 * degrees), root = 1 - v + z_of_quantile * std::sqrt(v);
            scratch.push_back(fit.across_m2 * moments.n / (degrees * variance_m2 * root * root * root));
            begin += (end - begin + 1) / 2;
        }
    }
    const double count = static_cast<double>(scratch.size());
    if (scratch.size() < min_stretches) return 1;
    const auto at = scratch.begin() + static_cast<std::ptrdiff_t>(quantile * count);
    std::nth_element(scratch.begin(), at, scratch.end());
    const double factor = *at;
    // The estimate scatters itself: a little more than the model says nothing, from a third more on it is
    // believed.
    const double doubt = 1 + 2.5 / std::sqrt(count);
    if (!(factor > doubt)) return 1;
    const double sure = 4.0 / 3.0 * doubt;
    const double believed = factor < sure ? 1 + (sure - 1) * (factor - doubt) / (sure - doubt) : factor;
    return std::min(believed, max_noise_factor);
}

}  // namespace loopline::lines
