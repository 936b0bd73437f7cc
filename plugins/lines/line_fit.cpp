#include "lines/line_fit.h"

#include <algorithm>

#include "lines/straightness.h"
#include "lines/vectorised.h"

namespace loopline::lines {
namespace {

constexpr double gate_sigmas = 3;
constexpr double end_sigmas = 2.5;
constexpr int max_steps = 8;
// A step below this part of the result's own sigma is the last: what another one would change is some
// hundredth of it.
constexpr double settled_sigmas = 0.3;
constexpr double singular = 1e-12;
constexpr std::size_t least_with_ends = 12;  // points of a run that can do without its ends
/// The stated noise counts as much as this many residuals, so that short lines are not judged by a handful of
/// them.
constexpr double prior_degrees_of_freedom = 30;
constexpr double max_autocorrelation = 0.95;

/// Slots of a run of n points: their number rounded up, and at least one empty one.
std::size_t slots(std::size_t n) {
    return (n / vector_points + 1) * vector_points;
}

NormalForm moved(const NormalForm& line, double delta_rho_m, double delta_alpha_rad) {
    // Turned by atan(delta_alpha): the same for the small steps that matter, and a safe unit vector for
    // others.
    const double scale = 1 / std::sqrt(1 + delta_alpha_rad * delta_alpha_rad);
    return {scale * (line.nx - line.ny * delta_alpha_rad), scale * (line.ny + line.nx * delta_alpha_rad),
            line.rho_m + delta_rho_m};
}

/// What the residuals say about the covariance that the noise model gives: by their size (the stated noise
/// taken as prior_degrees_of_freedom earlier residuals, and never less than stated), and by their order.
/// Residuals of an even wall are independent; on one that wobbles, bows or is a stair of grid cells
/// neighbours agree, and n of them are worth only n (1 - r) / (1 + r) with the autocorrelation r.
double covariance_factor(const LikelyFit& fit) {
    const double count = static_cast<double>(fit.count), degrees = count - 2;
    const double excess = fit.chi2 / degrees;
    const double by_size = excess > chi2_per_degree_limit(fit.count - 2)
                               ? excess
                               : (prior_degrees_of_freedom + fit.chi2) / (prior_degrees_of_freedom + degrees);
    const double r = std::min(fit.autocorrelation, max_autocorrelation);
    // No branch: whether neighbours agree can't be predicted.
    const double in_order = static_cast<double>((r * r * count > 4) & (r > 0));
    const double by_order = 1 + in_order * (2 * r / (1 - r));
    return std::max(1.0, by_size) * by_order;
}

}  // namespace

void LineFitter::clear() {
    lines_.clear();
    runs_.clear();
}

void LineFitter::add_line(const NormalForm& start, double variance_factor) {
    Line& line = lines_.emplace_back();
    line.fit.line = start;
    line.variance_factor = variance_factor;
    line.first_run = line.end_run = runs_.size();
}

void LineFitter::add_run(const Interval& run) {
    Line& line = lines_.back();
    if (line.first_run < line.end_run && runs_.back().end == run.begin) {
        runs_.back().end = run.end;
        return;
    }
    runs_.push_back(run);
    ++line.end_run;
}

void LineFitter::prepare(const ScanPoints& points) {
    std::size_t slot = 0;
    for (Line& line : lines_) {
        line.first_slot = slot;
        for (std::size_t k = line.first_run; k < line.end_run; ++k) slot += slots(runs_[k].size());
        line.end_slot = slot;
    }
    if (weights_.size() < slot) {
        weights_.resize(slot);
        residuals_m_.resize(slot);
    }
    if (ones_.size() < points.size() + vector_points) {
        ones_.assign(points.size(), 1);
        ones_.resize(points.size() + vector_points);
    }
}

void LineFitter::fit(const ScanPoints& points, const NoiseModel& noise) {
    open_.clear();
    for (Line& line : lines_) {
        cut_hanging_ends(points, noise, line);
        set_ends_apart(points, noise, line);
        open_.push_back(static_cast<std::size_t>(&line - lines_.data()));
    }
    prepare(points);
    // Gauss-Newton on (rho, alpha); the weights follow the line.
    for (int steps = 0; steps < max_steps && !open_.empty(); ++steps) {
        for (const std::size_t i : open_) sum_up(points, noise, lines_[i]);
        std::size_t still_open = 0;
        for (const std::size_t i : open_) {
            open_[still_open] = i;
            still_open += step(lines_[i]);
        }
        open_.resize(still_open);
    }
    for (Line& line : lines_) {
        if (line.fit.valid) describe_residuals(line);
        if (line.fit.valid) find_ends(points, noise, line);
    }
}

/// Cuts points until the two outermost ones at both ends lie on the line.
void LineFitter::cut_hanging_ends(const ScanPoints& points, const NoiseModel& noise, Line& line) {
    const double gate2 = end_sigmas * end_sigmas * line.variance_factor;
    const auto on_line = [&](std::size_t i) {
        return lies_on(points[i].x_m, points[i].y_m, line.fit.line, noise, gate2);
    };
    while (line.first_run < line.end_run) {
        Interval& run = runs_[line.first_run];
        if (run.size() > 1 && on_line(run.begin) & on_line(run.begin + 1)) break;
        if (++run.begin == run.end) ++line.first_run;
    }
    while (line.first_run < line.end_run) {
        Interval& run = runs_[line.end_run - 1];
        if (run.size() > 1 && on_line(run.end - 1) & on_line(run.end - 2)) break;
        if (--run.end == run.begin) --line.end_run;
    }
}

/// Where a wall ends, a beam may meet what stands beside or before it with all of its width or a part, and
/// was taken for the wall's by its residual alone: always too near, and with the longest lever. The same
/// corner does so in scan after scan, and no covariance tells. So the outermost beam of every run, and those
/// within what noise may hide of it, have no part in the fit.
void LineFitter::set_ends_apart(const ScanPoints& points, const NoiseModel& noise, Line& line) {
    if (line.first_run == line.end_run) return;
    line.first = runs_[line.first_run].begin;
    line.last = runs_[line.end_run - 1].end - 1;
    const double reach2_m2 = gate_sigmas * gate_sigmas * line.variance_factor * noise.range_variance_m2;
    for (std::size_t k = line.first_run; k < line.end_run; ++k) {
        Interval& run = runs_[k];
        if (run.size() < least_with_ends) continue;
        const std::size_t first = run.begin, last = run.end - 1;
        for (std::size_t left = std::max<std::size_t>(1, run.size() / 16); left > 0; --left) {
            if (points.squared_distance_m2(first, run.begin) <= reach2_m2) ++run.begin;
            if (points.squared_distance_m2(last, run.end - 1) <= reach2_m2) --run.end;
        }
    }
}

void LineFitter::sum_up(const ScanPoints& points, const NoiseModel& noise, Line& line) {
    line.sums = {};
    std::size_t slot = line.first_slot;
    for (std::size_t k = line.first_run; k < line.end_run; ++k) {
        const Interval run = runs_[k];
        const double* const counted = ones_.data() + (ones_.size() - vector_points - run.size());
        const NormalEquations sums =
            normal_equations(points.x_m() + run.begin, points.y_m() + run.begin, counted, slots(run.size()),
                             line.fit.line, noise, gate_sigmas * gate_sigmas * line.variance_factor,
                             weights_.data() + slot, residuals_m_.data() + slot);
        line.sums = line.sums + sums;
        slot += slots(run.size());
    }
}

/// Moves the line to where its equations say. True if it needs another step.
bool LineFitter::step(Line& line) {
    const NormalEquations sums = line.sums;
    LikelyFit& fit = line.fit;
    const double determinant = sums.w * sums.wtt - sums.wt * sums.wt, inverse = 1 / determinant;
    const double delta_rho_m = (sums.wtt * sums.wd - sums.wt * sums.wtd) * inverse;
    const double delta_alpha_rad = (sums.wt * sums.wd - sums.w * sums.wtd) * inverse;
    fit.line = moved(fit.line, delta_rho_m, delta_alpha_rad);
    // Inverse of the Fisher information, the sum of J' J / var(d) with J = (-1, t).
    const double variance_rho = sums.wtt * inverse, variance_alpha = sums.w * inverse,
                 covariance = sums.wt * inverse;
    fit.covariance << variance_rho, covariance, covariance, variance_alpha;
    fit.chi2 = sums.wdd - delta_rho_m * sums.wd + delta_alpha_rad * sums.wtd;

    const bool possible = (determinant > singular * sums.w * sums.wtt) & (fit.line.rho_m > 0);
    const double settled2 = settled_sigmas * settled_sigmas;
    const bool settled = (delta_rho_m * delta_rho_m < settled2 * variance_rho) &
                         (delta_alpha_rad * delta_alpha_rad < settled2 * variance_alpha);
    fit.valid = possible & settled;
    return possible & !settled;
}

/// Says which points are in the fit, and by how much and in which order they are off.
void LineFitter::describe_residuals(Line& line) {
    const NormalEquations& sums = line.sums;
    LikelyFit& fit = line.fit;
    fit.count = static_cast<std::size_t>(sums.count);
    fit.valid = fit.count >= 3;
    if (!fit.valid) return;
    fit.rms_m = std::sqrt(sums.dd / sums.count);
    const double wdd_lagged =
        lagged_squares(weights_.data() + line.first_slot, residuals_m_.data() + line.first_slot,
                       line.end_slot - line.first_slot);
    fit.autocorrelation = sums.wdd > 0 ? wdd_lagged / sums.wdd : 0;
    fit.covariance *= covariance_factor(fit);
}

/// Outermost points on the line: of those in the fit, or of those that were set apart.
void LineFitter::find_ends(const ScanPoints& points, const NoiseModel& noise, Line& line) const {
    LikelyFit& fit = line.fit;
    const std::size_t first = first_in_fit(line), last = last_in_fit(line);
    const auto on_line = [&](std::size_t i) {
        return lies_on(points[i].x_m, points[i].y_m, fit.line, noise,
                       gate_sigmas * gate_sigmas * line.variance_factor);
    };
    fit.first = line.first;
    while (fit.first < first && !on_line(fit.first)) ++fit.first;
    fit.last = line.last;
    while (fit.last > last && !on_line(fit.last)) --fit.last;
    fit.ends = (first - fit.first) + (fit.last - last);
}

std::size_t LineFitter::first_in_fit(const Line& line) const {
    std::size_t slot = line.first_slot;
    for (std::size_t k = line.first_run; k < line.end_run; slot += slots(runs_[k].size()), ++k)
        for (std::size_t i = 0; i < runs_[k].size(); ++i)
            if (weights_[slot + i] > 0) return runs_[k].begin + i;
    return runs_[line.end_run - 1].end;
}

std::size_t LineFitter::last_in_fit(const Line& line) const {
    std::size_t slot = line.end_slot;
    for (std::size_t k = line.end_run; k-- > line.first_run;) {
        slot -= slots(runs_[k].size());
        for (std::size_t i = runs_[k].size(); i-- > 0;)
            if (weights_[slot + i] > 0) return runs_[k].begin + i;
    }
    return runs_[line.first_run].begin;
}

}  // namespace loopline::lines
