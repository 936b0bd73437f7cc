#include "lines/line_fit.h"

#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {

constexpr double gate_sigmas = 3;
constexpr double end_sigmas = 2.5;
constexpr int max_steps = 8;
constexpr double settled_sigmas = 1e-2;     // a step below this part of the result's own sigma is the last
constexpr double min_cos_incidence = 0.02;  // 88.9 degrees: a beam along the wall says nothing about it
constexpr double singular = 1e-12;

/// A beam seen from a line: residual d, weight 1 / var(d), and where the beam would meet the line. The last
/// follows from the beam's direction alone: the measured range is off by the same noise as d, and would bias
/// alpha.
struct Residual {
    bool usable;
    double d_m, weight, t_m;
};

Residual residual(const ScanPoint& p, bool at_edge, const NormalForm& line, const NoiseModel& noise) {
    const double cos_incidence = p.cos_bearing * line.nx + p.sin_bearing * line.ny;
    if (cos_incidence < min_cos_incidence) return {false, 0, 0, 0};
    const double sin_incidence = p.sin_bearing * line.nx - p.cos_bearing * line.ny;
    const double tt_cos2 = line.rho_m * line.rho_m * sin_incidence * sin_incidence,
                 cos2 = cos_incidence * cos_incidence;
    // variance cos^2 and t cos, so that one division serves both.
    double variance_cos2 = (noise.range_variance_m2 * cos2 + noise.wall_variance_m2) * cos2 +
                           noise.bearing_variance_rad2 * tt_cos2;
    if (at_edge)
        variance_cos2 +=
            noise.edge_variance_rad2 * p.range_m * p.range_m * sin_incidence * sin_incidence * cos2;
    const double inverse = 1 / (variance_cos2 * cos_incidence);
    return {true, p.range_m * cos_incidence - line.rho_m, cos2 * cos_incidence * inverse,
            line.rho_m * sin_incidence * variance_cos2 * inverse};
}

bool within(const Residual& r, double gate2) {
    return r.usable && r.d_m * r.d_m * r.weight <= gate2;
}

/// Weighted sums of the normal equations of d = delta_rho - t delta_alpha, and what is reported of the
/// points.
struct NormalEquations {
    double w = 0, wt = 0, wtt = 0, wd = 0, wtd = 0, wdd = 0, wdd_lagged = 0, dd = 0, previous_d_m = 0;
    std::size_t count = 0, first = 0, last = 0;

    void add(const Residual& r, std::size_t i) {
        const double weighted_t = r.weight * r.t_m, weighted_d = r.weight * r.d_m;
        w += r.weight;
        wt += weighted_t;
        wtt += weighted_t * r.t_m;
        wd += weighted_d;
        wtd += weighted_t * r.d_m;
        wdd += weighted_d * r.d_m;
        wdd_lagged += weighted_d * previous_d_m;
        previous_d_m = r.d_m;
        dd += r.d_m * r.d_m;
        if (count++ == 0) first = i;
        last = i;
    }
    double determinant() const { return w * wtt - wt * wt; }
    bool solvable() const { return count >= 3 && determinant() > singular * w * wtt; }
    double delta_rho_m() const { return (wtt * wd - wt * wtd) / determinant(); }
    double delta_alpha_rad() const { return (wt * wd - w * wtd) / determinant(); }
};

NormalForm moved(const NormalForm& line, double delta_rho_m, double delta_alpha_rad) {
    // Turned by atan(delta_alpha): the same for the small steps that matter, and a safe unit vector for
    // others.
    const double scale = 1 / std::sqrt(1 + delta_alpha_rad * delta_alpha_rad);
    return {scale * (line.nx - line.ny * delta_alpha_rad), scale * (line.ny + line.nx * delta_alpha_rad),
            line.rho_m + delta_rho_m};
}

}  // namespace

QuickFit quick_fit(const Moments& m) {
    const double mean_x = m.x / m.n, mean_y = m.y / m.n;
    const double sxx = m.xx / m.n - mean_x * mean_x, syy = m.yy / m.n - mean_y * mean_y;
    const double sxy = m.xy / m.n - mean_x * mean_y;
    const double difference = sxx - syy, twice_sxy = 2 * sxy;
    const double spread = std::sqrt(difference * difference + twice_sxy * twice_sxy);

    QuickFit fit;
    // The line runs along (cos a, sin a), where (cos 2a, sin 2a) = (difference, twice_sxy) / spread.
    double cos_a = 1, sin_a = 0;
    if (spread > 0 && difference >= 0) {
        cos_a = std::sqrt(0.5 * (1 + difference / spread));
        sin_a = 0.5 * twice_sxy / (spread * cos_a);
    } else if (spread > 0) {
        sin_a = std::sqrt(0.5 * (1 - difference / spread));
        cos_a = 0.5 * twice_sxy / (spread * sin_a);
    }
    fit.line = {-sin_a, cos_a, -sin_a * mean_x + cos_a * mean_y};
    if (fit.line.rho_m < 0) fit.line = {-fit.line.nx, -fit.line.ny, -fit.line.rho_m};
    fit.across_m2 = std::max(0.0, 0.5 * (sxx + syy - spread));
    fit.along_m2 = std::max(0.0, 0.5 * (sxx + syy + spread));
    return fit;
}

LikelyFit likely_fit(const ScanPoints& points, const Interval& run, const std::vector<int>& labels, int label,
                     const NormalForm& start, const NoiseModel& noise, double variance_factor) {
    LikelyFit fit;
    const double gate2 = gate_sigmas * gate_sigmas * variance_factor;
    const double end_gate2 = end_sigmas * end_sigmas * variance_factor;
    fit.line = start;

    const auto at_edge = [&](std::size_t i) {
        return i == 0 || i + 1 == points.size() || labels[i - 1] != label || labels[i + 1] != label;
    };
    Interval ends = run;
    const auto hangs_off = [&](std::size_t i) {
        return labels[i] != label || !within(residual(points[i], at_edge(i), fit.line, noise), end_gate2);
    };
    while (ends.size() > 2 && (hangs_off(ends.begin) || hangs_off(ends.begin + 1))) ++ends.begin;
    while (ends.size() > 2 && (hangs_off(ends.end - 1) || hangs_off(ends.end - 2))) --ends.end;

    // Gauss-Newton on (rho, alpha); the weights follow the line.
    for (int step = 0; step < max_steps; ++step) {
        NormalEquations sums;
        for (std::size_t i = ends.begin; i < ends.end; ++i) {
            if (labels[i] != label) continue;
            const Residual r = residual(points[i], at_edge(i), fit.line, noise);
            if (within(r, gate2)) sums.add(r, i);
        }
        if (!sums.solvable()) return fit;
        const double delta_rho_m = sums.delta_rho_m(), delta_alpha_rad = sums.delta_alpha_rad();
        fit.line = moved(fit.line, delta_rho_m, delta_alpha_rad);
        if (!(fit.line.rho_m > 0)) return fit;

        const double settled2 = settled_sigmas * settled_sigmas;
        if (delta_rho_m * delta_rho_m * sums.determinant() < settled2 * sums.wtt &&
            delta_alpha_rad * delta_alpha_rad * sums.determinant() < settled2 * sums.w) {
            fit.valid = true;
            // Inverse of the Fisher information, the sum of J' J / var(d) with J = (-1, t).
            fit.covariance << sums.wtt, sums.wt, sums.wt, sums.w;
            fit.covariance /= sums.determinant();
            fit.chi2 = sums.wdd;
            fit.rms_m = std::sqrt(sums.dd / static_cast<double>(sums.count));
            fit.autocorrelation = sums.wdd > 0 ? sums.wdd_lagged / sums.wdd : 0;
            fit.count = sums.count;
            fit.first = sums.first;
            fit.last = sums.last;
            return fit;
        }
    }
    return fit;
}

}  // namespace loopline::lines
