#include "lines/line_assembler.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {

constexpr double chi2_2_99 = 9.2103;
/// The stated noise counts as much as this many residuals, so that short lines are not judged by a handful of
/// them.
constexpr double prior_degrees_of_freedom = 30;

double along_m(const NormalForm& line, const ScanPoint& p) {
    return line.along_m(p.x_m, p.y_m);
}

/// Angle from a's normal to b's, in [-pi/2, pi/2] for lines seen from the same side.
double turn_rad(const NormalForm& a, const NormalForm& b) {
    return std::asin(std::clamp(a.nx * b.ny - a.ny * b.nx, -1.0, 1.0));
}

LineSegment segment_of(const ScanPoints& points, const LikelyFit& fit, std::size_t first, std::size_t last) {
    const double c = std::cos(points.middle_angle_rad()), s = std::sin(points.middle_angle_rad());
    const NormalForm& line = fit.line;
    const Eigen::Vector2d normal(c * line.nx - s * line.ny, s * line.nx + c * line.ny);
    const Eigen::Vector2d tangent(-normal.y(), normal.x());
    LineSegment segment;
    segment.rho_m = line.rho_m;
    segment.alpha_rad = wrap_to_pi(std::atan2(line.ny, line.nx) + points.middle_angle_rad());
    segment.covariance = fit.covariance;
    segment.start_m = line.rho_m * normal + along_m(line, points[first]) * tangent;
    segment.end_m = line.rho_m * normal + along_m(line, points[last]) * tangent;
    segment.first_beam = points[first].beam;
    segment.last_beam = points[last].beam;
    segment.beam_count = fit.count;
    segment.rms_m = fit.rms_m;
    return segment;
}

}  // namespace

void LineAssembler::assemble(const ScanPoints& points, const std::vector<Piece>& pieces,
                             const NoiseModel& noise, const ExtractionParameters& parameters,
                             LineSegments& segments) {
    candidates_.clear();
    labels_.assign(points.size(), -1);
    for (const Piece& piece : pieces) {
        Candidate c;
        c.label = static_cast<int>(candidates_.size());
        c.run = piece.run;
        c.moments = points.moments(piece.run);
        std::fill(labels_.begin() + static_cast<std::ptrdiff_t>(c.run.begin),
                  labels_.begin() + static_cast<std::ptrdiff_t>(c.run.end), c.label);
        c.rejected = !fit(points, noise, c);
        candidates_.push_back(c);
    }
    drop_chains_of_chords(points, pieces, parameters);
    merge_collinear(points, noise, parameters);

    segments.clear();
    for (const Candidate& c : candidates_)
        if (!c.rejected && acceptable(points, parameters, c))
            segments.push_back(segment_of(points, c.fit, c.first, c.last));
    std::sort(segments.begin(), segments.end(),
              [](const LineSegment& a, const LineSegment& b) { return a.first_beam < b.first_beam; });
}

bool LineAssembler::fit(const ScanPoints& points, const NoiseModel& noise, Candidate& c) const {
    const QuickFit quick = quick_fit(c.moments);
    const double variance_m2 = noise.mean_variance_m2(c.moments, quick.line.rho_m);
    const double excess = quick.across_m2 * c.moments.n / ((c.moments.n - 2) * variance_m2);
    c.fit = likely_fit(points, c.run, labels_, c.label, quick.line, noise, std::max(1.0, excess));
    if (!c.fit.valid) return false;
    // The noise that the residuals show, the stated noise taken as prior_degrees_of_freedom earlier ones;
    // never less than stated.
    const double residual_count = static_cast<double>(c.fit.count) - 2;
    c.fit.covariance *=
        std::max(1.0, (prior_degrees_of_freedom + c.fit.chi2) / (prior_degrees_of_freedom + residual_count));
    if (!c.over_the_seam) {
        c.first = c.fit.first;
        c.last = c.fit.last;
    }
    return true;
}

bool LineAssembler::acceptable(const ScanPoints& points, const ExtractionParameters& parameters,
                               const Candidate& c) const {
    const double length_m = along_m(c.fit.line, points[c.last]) - along_m(c.fit.line, points[c.first]);
    return c.fit.count >= static_cast<std::size_t>(parameters.min_beams) &&
           length_m >= parameters.min_length_m &&
           c.fit.covariance(1, 1) <= parameters.max_sigma_alpha_rad * parameters.max_sigma_alpha_rad;
}

/// A round wall falls into chords that touch and turn a little from one to the next. Two neighbours of
/// lengths a, b that turn by delta suggest the curvature delta / ((a + b) / 2); a chord of that arc has a
/// sagitta that its own points would show. What does not show itself straighter than that, and would turn
/// noticeably, is no wall.
void LineAssembler::drop_chains_of_chords(const ScanPoints& points, const std::vector<Piece>& pieces,
                                          const ExtractionParameters& parameters) {
    const double noticeable_rad = 2 * parameters.max_sigma_alpha_rad;
    const auto length_m = [&](const Candidate& c) {
        return along_m(c.fit.line, points[c.last]) - along_m(c.fit.line, points[c.first]);
    };
    const auto could_be_chord = [&](const Candidate& c, const Piece& piece, double curvature_per_m) {
        const double length = length_m(c);
        const double implied_m = std::abs(curvature_per_m) * length * length / 8;
        const double shown_m = curvature_per_m > 0 ? piece.shape.sagitta_m : -piece.shape.sagitta_m;
        return std::abs(curvature_per_m) * length > noticeable_rad &&
               shown_m + piece.shape.sigma_sagitta_m > implied_m / 2;
    };
    const auto directed = [&](const Candidate& c) {
        return c.fit.valid && c.fit.covariance(1, 1) < noticeable_rad * noticeable_rad;
    };
    for (std::size_t i = 0; i + 1 < candidates_.size(); ++i) {
        Candidate &a = candidates_[i], &b = candidates_[i + 1];
        if (pieces[i].run.end != pieces[i + 1].run.begin || !directed(a) || !directed(b)) continue;
        const double turn = turn_rad(a.fit.line, b.fit.line);
        if (std::abs(turn) > parameters.angle_threshold_rad) continue;
        const double curvature_per_m = turn / std::max(1e-6, 0.5 * (length_m(a) + length_m(b)));
        if (could_be_chord(a, pieces[i], curvature_per_m)) a.rejected = true;
        if (could_be_chord(b, pieces[i + 1], curvature_per_m)) b.rejected = true;
    }
}

void LineAssembler::merge_collinear(const ScanPoints& points, const NoiseModel& noise,
                                    const ExtractionParameters& parameters) {
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
        if (candidates_[i].rejected) continue;
        for (std::size_t j = i + 1; j < candidates_.size(); ++j)
            if (!candidates_[j].rejected)
                merge(points, noise, parameters, candidates_[i], candidates_[j], false);
    }
    if (!points.full_circle()) return;
    for (std::size_t i = 0; i < candidates_.size(); ++i)
        for (std::size_t j = candidates_.size() - 1; j > i; --j)
            if (!candidates_[i].rejected && !candidates_[j].rejected)
                merge(points, noise, parameters, candidates_[i], candidates_[j], true);
}

/// Takes b's points into a if both are one line: close enough, equal within their covariances, and straight
/// together.
bool LineAssembler::merge(const ScanPoints& points, const NoiseModel& noise,
                          const ExtractionParameters& parameters, Candidate& a, Candidate& b,
                          bool over_the_seam) {
    const NormalForm &line_a = a.fit.line, &line_b = b.fit.line;
    if (line_a.nx * line_b.nx + line_a.ny * line_b.ny < 0.95) return false;

    const double limit_m = acceptable(points, parameters, a) && acceptable(points, parameters, b)
                               ? parameters.max_merge_gap_m
                               : std::min(parameters.max_merge_gap_m, parameters.max_gap_m);
    const std::size_t near_a = over_the_seam ? a.first : a.last, near_b = over_the_seam ? b.last : b.first;
    if (points.squared_distance_m2(near_a, near_b) > limit_m * limit_m) return false;

    // A wall that bows a little has pieces that differ by more than noise, in direction and where they meet.
    const double t_m = along_m(line_a, points[near_b]);
    Eigen::Matrix2d covariance = a.fit.covariance + b.fit.covariance;
    const double bow2 = 4 * parameters.max_bow * parameters.max_bow;
    covariance(0, 0) += noise.wall_variance_m2 + bow2 * t_m * t_m;
    covariance(0, 1) += bow2 * t_m;
    covariance(1, 0) += bow2 * t_m;
    covariance(1, 1) += bow2;
    const Eigen::Vector2d difference(line_b.rho_m - line_a.rho_m, turn_rad(line_a, line_b));
    if (difference.dot(covariance.inverse() * difference) > chi2_2_99) return false;

    const Moments moments = a.moments + b.moments;
    const QuickFit together = quick_fit(moments);
    const double bow_m = parameters.max_bow * std::sqrt(12 * together.along_m2);
    if (together.across_m2 >
        chi2_per_degree_limit(moments.n - 2) * noise.mean_variance_m2(moments, together.line.rho_m) +
            4.0 / 45.0 * bow_m * bow_m)
        return false;

    Candidate merged = a;
    merged.run = {std::min(a.run.begin, b.run.begin), std::max(a.run.end, b.run.end)};
    merged.moments = moments;
    merged.over_the_seam = a.over_the_seam || over_the_seam;
    if (over_the_seam) {
        merged.first = b.first;
        merged.last = a.last;
    }
    std::replace(labels_.begin() + static_cast<std::ptrdiff_t>(b.run.begin),
                 labels_.begin() + static_cast<std::ptrdiff_t>(b.run.end), b.label, a.label);
    if (!fit(points, noise, merged)) {
        // No line through both after all: the beams of b are lost to it, the line of a stands.
        b.rejected = true;
        return false;
    }
    a = merged;
    b.rejected = true;
    return true;
}

}  // namespace loopline::lines
