#include "lines/noise_model.h"

#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {
constexpr double default_sigma_range_m = 0.01;
constexpr double max_noise_factor = 36;  // six times the stated sigma: beyond that it is clutter, not noise
constexpr double stretch_m = 1;
constexpr std::size_t min_stretches = 4;
constexpr double quantile = 0.4, z_of_quantile = -0.2533;
}  // namespace

NoiseModel stated_noise(const ExtractionParameters& parameters, double scan_sigma_range_m) {
    double sigma_range_m = parameters.sigma_range_m;
    if (!(sigma_range_m > 0)) sigma_range_m = scan_sigma_range_m;
    if (!(sigma_range_m > 0)) sigma_range_m = default_sigma_range_m;
    return {sigma_range_m * sigma_range_m, parameters.sigma_bearing_rad * parameters.sigma_bearing_rad,
            parameters.sigma_wall_m * parameters.sigma_wall_m};
}

void NoiseMeter::tabulate_quantiles(std::size_t points) {
    for (std::size_t n = quantiles_.size(); n <= points; ++n) {
        // Wilson and Hilferty: the quantile of chi-square per degree of freedom.
        const double count = static_cast<double>(n), degrees = std::max(1.0, count - 2);
        const double v = 2 / (9 * degrees), root = 1 - v + z_of_quantile * std::sqrt(v);
        quantiles_.push_back(degrees * root * root * root / count);
    }
}

double NoiseMeter::factor(const ScanPoints& points, const std::vector<Interval>& runs,
                          const NoiseModel& noise) {
    tabulate_quantiles(points.size());
    ratios_.clear();
    for (const Interval& run : runs) {
        std::size_t begin = run.begin, end = begin;
        while (begin + min_points <= run.end) {
            // It does not end before the last one did.
            end = std::max(end, begin + min_points);
            while (end < run.end && points.squared_distance_m2(begin, end - 1) < stretch_m * stretch_m) ++end;
            const Moments moments = points.moments({begin, end});
            const PrincipalAxes axes = principal_axes(moments);
            ratios_.push_back(axes.across_m2 /
                              (noise.mean_variance_m2(moments, axes) * quantiles_[end - begin]));
            begin += (end - begin + 1) / 2;
        }
    }
    if (ratios_.size() < min_stretches) return 1;
    const double count = static_cast<double>(ratios_.size());
    // The estimate scatters itself: a little more than the model says nothing, from a third more on it is
    // believed.
    const double doubt = 1 + 2.5 / std::sqrt(count);
    const auto rank = static_cast<std::ptrdiff_t>(quantile * count);
    if (std::count_if(ratios_.begin(), ratios_.end(), [doubt](double r) { return r <= doubt; }) > rank)
        return 1;
    std::nth_element(ratios_.begin(), ratios_.begin() + rank, ratios_.end());
    const double factor = ratios_[static_cast<std::size_t>(rank)];
    const double sure = 4.0 / 3.0 * doubt;
    const double believed = factor < sure ? 1 + (sure - 1) * (factor - doubt) / (sure - doubt) : factor;
    return std::min(believed, max_noise_factor);
}

}  // namespace loopline::lines
