#include "lines/line_assembler.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lines/chord_chains.h"

namespace loopline::lines {
namespace {

constexpr double chi2_2_99 = 9.2103;
constexpr double extension_sigmas2 = 4;

double along_m(const NormalForm& line, const ScanPoint& p) {
    return line.along_m(p.x_m, p.y_m);
}

/// The piece with the points beside it, within `free`, that lie on its line: where a break was a little off a
/// corner, what it cut off was too short for a piece.
Interval extended(const ScanPoints& points, const Piece& piece, const Interval& free) {
    const NormalForm& line = piece.shape.fit.line;
    const double variance_m2 = std::max(piece.shape.fit.across_m2, piece.shape.variance_m2);
    const auto belongs = [&](std::size_t i) {
        const double d_m = line.distance_m(points[i].x_m, points[i].y_m);
        return d_m * d_m < extension_sigmas2 * variance_m2;
    };
    Interval run = piece.run;
    while (run.begin > free.begin && belongs(run.begin - 1)) --run.begin;
    while (run.end < free.end && belongs(run.end)) ++run.end;
    return run;
}

LineSegment segment_of(const ScanPoints& points, const LikelyFit& fit, std::size_t first, std::size_t last) {
    const double c = points.cos_middle(), s = points.sin_middle();
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
    segment.beam_count = fit.count + fit.ends;
    segment.rms_m = fit.rms_m;
    return segment;
}

}  // namespace

void LineAssembler::assemble(const ScanPoints& points, const std::vector<Piece>& pieces,
                             const NoiseModel& noise, const ExtractionParameters& parameters,
                             LineSegments& segments) {
    candidates_.clear();
    fitter_.clear();
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const Piece& piece = pieces[i];
        LineCandidate& c = candidates_.emplace_back();
        c.line = i;
        c.part = piece.run;
        if (piece.arc || piece.run.size() < static_cast<std::size_t>(parameters.min_beams)) {
            c.run = c.part;
            c.rejected = true;
            continue;
        }
        const std::size_t previous_end = i > 0 ? candidates_[i - 1].part.end : 0;
        const std::size_t next_begin = i + 1 < pieces.size() ? pieces[i + 1].run.begin : points.size();
        c.part = c.run =
            extended(points, piece,
                     {std::max(piece.block.begin, previous_end), std::min(piece.block.end, next_begin)});
        c.moments = points.moments(c.run);
        const bool longer = c.run.size() > piece.run.size();
        start(longer ? quick_fit(c.moments) : piece.shape.fit, c.moments, noise);
        fitter_.add_run(c.run);
    }
    fitter_.fit(points, noise);
    std::size_t fitted = 0;
    for (LineCandidate& c : candidates_)
        if (!c.rejected) c.take(fitter_[fitted++]);
    drop_chains_of_chords(points, pieces, parameters, candidates_);
    merge_collinear(points, noise, parameters);

    segments.clear();
    for (const LineCandidate& c : candidates_)
        if (!c.rejected && acceptable(points, parameters, c))
            segments.push_back(segment_of(points, c.fit, c.first, c.last));
    std::sort(segments.begin(), segments.end(),
              [](const LineSegment& a, const LineSegment& b) { return a.first_beam < b.first_beam; });
}

/// Has a line fitted to points of these moments, from their quick fit.
void LineAssembler::start(const QuickFit& quick, const Moments& moments, const NoiseModel& noise) {
    const double variance_m2 = noise.mean_variance_m2(moments, quick);
    const double excess = quick.across_m2 * moments.n / ((moments.n - 2) * variance_m2);
    fitter_.add_line(quick.line, std::max(1.0, excess));
}

/// Fits the line again to all its parts.
bool LineAssembler::refit(const ScanPoints& points, const NoiseModel& noise, const QuickFit& together,
                          LineCandidate& c) {
    fitter_.clear();
    start(together, c.moments, noise);
    for (const LineCandidate& other : candidates_)
        if (other.line == c.line && other.part.begin >= c.run.begin && other.part.end <= c.run.end)
            fitter_.add_run(other.part);
    fitter_.fit(points, noise);
    c.take(fitter_[0]);
    return !c.rejected;
}

bool LineAssembler::acceptable(const ScanPoints& points, const ExtractionParameters& parameters,
                               const LineCandidate& c) const {
    return c.fit.count + c.fit.ends >= static_cast<std::size_t>(parameters.min_beams) &&
           c.length_m(points) >= parameters.min_length_m &&
           c.fit.covariance(1, 1) <= parameters.max_sigma_alpha_rad * parameters.max_sigma_alpha_rad;
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
                          const ExtractionParameters& parameters, LineCandidate& a, LineCandidate& b,
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
    const double apart_m2 =
        (a.moments.n * quick_fit(a.moments).across_m2 + b.moments.n * quick_fit(b.moments).across_m2) /
        moments.n;
    const double variance_m2 = std::max(apart_m2, noise.mean_variance_m2(moments, together));
    if (together.across_m2 > chi2_per_degree_limit(static_cast<std::size_t>(moments.n) - 2) * variance_m2 +
                                 4.0 / 45.0 * bow_m * bow_m)
        return false;

    LineCandidate merged = a;
    merged.run = {std::min(a.run.begin, b.run.begin), std::max(a.run.end, b.run.end)};
    merged.moments = moments;
    merged.over_the_seam = a.over_the_seam || over_the_seam;
    if (over_the_seam) {
        merged.first = b.first;
        merged.last = a.last;
    }
    for (LineCandidate& other : candidates_)
        if (other.line == b.line) other.line = a.line;
    if (!refit(points, noise, together, merged)) {
        // No line through both after all: the beams of b are lost to it, the line of a stands.
        b.rejected = true;
        return false;
    }
    a = merged;
    b.rejected = true;
    return true;
}

}  // namespace loopline::lines
