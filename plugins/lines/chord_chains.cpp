#include "lines/chord_chains.h"

#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {
constexpr double max_round_radius_m = 20;
constexpr std::size_t max_points_between = 2;  // of neighbours that touch
}  // namespace

void drop_chains_of_chords(const ScanPoints& points, const std::vector<Piece>& pieces,
                           const ExtractionParameters& parameters, std::vector<LineCandidate>& candidates) {
    const double noticeable_rad = 2 * parameters.max_sigma_alpha_rad;
    // Rejects c if it may be a chord of an arc that a neighbour of some length suggests.
    const auto judge = [&](LineCandidate& c, const Piece& piece, double curvature_per_m, double neighbour_m) {
        const double length = c.length_m(points);
        if (std::abs(curvature_per_m) < 1 / max_round_radius_m || neighbour_m < length / 2 ||
            std::abs(curvature_per_m) * length < noticeable_rad)
            return;
        const double implied_m = std::abs(curvature_per_m) * length * length / 8;
        const double shown_m = curvature_per_m > 0 ? piece.shape.sagitta_m : -piece.shape.sagitta_m;
        if (shown_m + piece.shape.sigma_sagitta_m > implied_m / 2) c.rejected = true;
    };
    const auto enough_beams = [&](const LineCandidate& c) {
        return c.run.size() >= static_cast<std::size_t>(parameters.min_beams);
    };
    for (std::size_t i = 0; i + 1 < candidates.size(); ++i) {
        LineCandidate &a = candidates[i], &b = candidates[i + 1];
        const Piece &piece_a = pieces[i], &piece_b = pieces[i + 1];
        if (piece_a.run.end + max_points_between < piece_b.run.begin || !enough_beams(a) || !enough_beams(b))
            continue;
        const bool arc_a = piece_a.arc, arc_b = piece_b.arc;
        if (arc_a && arc_b) continue;
        const double turn = turn_rad(piece_a.shape.fit.line, piece_b.shape.fit.line);
        if (arc_a || arc_b) {
            const Straightness& arc = arc_a ? piece_a.shape : piece_b.shape;
            const double arc_m = std::sqrt(12 * arc.fit.along_m2);
            const double curvature_per_m = 8 * arc.sagitta_m / (arc_m * arc_m);
            // Half of the arc's own turn lies between its chord and its end.
            if (std::abs(turn - curvature_per_m * arc_m / 2) > parameters.angle_threshold_rad) continue;
            LineCandidate& straight = arc_a ? b : a;
            if (!straight.rejected) judge(straight, arc_a ? piece_b : piece_a, curvature_per_m, arc_m);
        } else if (a.fit.valid && b.fit.valid && std::abs(turn) <= parameters.angle_threshold_rad) {
            const double length_a = a.length_m(points), length_b = b.length_m(points);
            const double curvature_per_m = turn / std::max(1e-6, 0.5 * (length_a + length_b));
            judge(a, piece_a, curvature_per_m, length_b);
            judge(b, piece_b, curvature_per_m, length_a);
        }
    }
}

}  // namespace loopline::lines
