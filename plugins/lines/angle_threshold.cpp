#include "lines/angle_threshold.h"

#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {
constexpr std::size_t shortest_chord = 3;  // points on each side, the one in the middle counted in both
constexpr double significant2 = 9;         // a turn below three of its sigmas may be noise
}  // namespace

AngleThreshold::AngleThreshold(const ExtractionParameters& parameters)
    : BlockwiseExtractor(parameters),
      sin2_threshold_(std::pow(std::sin(parameters.angle_threshold_rad), 2)),
      wanted_variance_(std::pow(parameters.angle_threshold_rad / 4, 2)) {}

AngleThreshold::Turn AngleThreshold::turn_at(const Interval& block, std::size_t point,
                                             std::size_t chord_points) const {
    const std::size_t first = point - std::min(point - block.begin, chord_points - 1);
    const std::size_t last = std::min(point + chord_points, block.end) - 1;
    const Moments before = points_.moments({first, point + 1}), after = points_.moments({point, last + 1});

    // Twice the chord's direction is that of (sxx - syy, 2 sxy); sums of squares here, not means.
    const auto direction = [](const Moments& m, double& cos2, double& sin2, double& squares) {
        const double inverse_n = 1 / m.n;
        const double sxx = m.xx - m.x * m.x * inverse_n, syy = m.yy - m.y * m.y * inverse_n;
        cos2 = sxx - syy;
        sin2 = 2 * (m.xy - m.x * m.y * inverse_n);
        squares = sxx + syy;
    };
    double cos2_before, sin2_before, squares_before, cos2_after, sin2_after, squares_after;
    direction(before, cos2_before, sin2_before, squares_before);
    direction(after, cos2_after, sin2_after, squares_after);

    Turn turn;
    const double dot = cos2_before * cos2_after + sin2_before * sin2_after;
    const double lengths = std::sqrt((cos2_before * cos2_before + sin2_before * sin2_before) *
                                     (cos2_after * cos2_after + sin2_after * sin2_after));
    turn.sin2 = lengths > 0 ? 0.5 * (1 - dot / lengths) : 0;
    // A line's direction is known only up to pi: a path that turns back is told by its chords' end points.
    const ScanPoint p = points_[first], q = points_[point], r = points_[last];
    if ((q.x_m - p.x_m) * (r.x_m - q.x_m) + (q.y_m - p.y_m) * (r.y_m - q.y_m) < 0) turn.sin2 = 2 - turn.sin2;
    // var(direction) = var(d) / (sum of squares along the chord).
    const double cross = q.x_m * (r.y_m - p.y_m) - q.y_m * (r.x_m - p.x_m);
    const double chord2 = points_.squared_distance_m2(first, last);
    const double r2 = q.squared_range_m2();
    const double cos2_incidence = chord2 > 0 ? std::min(1.0, cross * cross / (chord2 * r2)) : 1;
    const double variance_m2 = noise_.range_variance_m2 * cos2_incidence + noise_.wall_variance_m2 +
                               noise_.bearing_variance_rad2 * r2 * (1 - cos2_incidence);
    turn.variance = variance_m2 * (1 / std::max(squares_before, 1e-12) + 1 / std::max(squares_after, 1e-12));
    return turn;
}

void AngleThreshold::find_corners(const Interval& block) {
    turns_.clear();
    std::size_t chord_points = shortest_chord, stride = 1;
    for (std::size_t point = block.begin + shortest_chord - 1; point + shortest_chord <= block.end;
         point += stride) {
        // Neighbours need about the same chords: try one point less than the last did, then grow.
        chord_points = std::max(shortest_chord, chord_points - 1);
        Turn turn = turn_at(block, point, chord_points);
        while (turn.variance > wanted_variance_ &&
               (point - block.begin >= chord_points || point + chord_points < block.end)) {
            chord_points += 1 + chord_points / 8;
            turn = turn_at(block, point, chord_points);
        }
        if (turn.sin2 > sin2_threshold_ && turn.sin2 > significant2 * turn.variance) {
            turn.point = point;
            turn.chord_points = chord_points;
            turns_.push_back(turn);
        }
        // The turn rises and falls over a chord's length on both sides of a corner: no need to look at every
        // point.
        stride = std::max<std::size_t>(1, chord_points / 4);
    }

    // One corner per neighbourhood: the sharpest turn within half a chord.
    corners_.clear();
    for (std::size_t i = 0; i < turns_.size(); ++i) {
        const std::size_t half = std::max<std::size_t>(1, turns_[i].chord_points / 2);
        bool sharpest = true;
        for (std::size_t k = i; k-- > 0 && turns_[k].point + half >= turns_[i].point && sharpest;)
            sharpest = turns_[k].sin2 < turns_[i].sin2;
        for (std::size_t k = i + 1;
             k < turns_.size() && turns_[k].point <= turns_[i].point + half && sharpest; ++k)
            sharpest = turns_[k].sin2 <= turns_[i].sin2;
        if (sharpest) corners_.push_back(turns_[i]);
    }
}

void AngleThreshold::split(const Interval& block) {
    const Straightness whole = straightness(points_, block, noise_, parameters_.max_bow);
    if (whole.shape == Shape::straight && !hides_a_step(points_, block, whole, noise_)) {
        pieces_.push_back({block, whole, false, {}});
        return;
    }
    find_corners(block);
    std::size_t begin = block.begin;
    for (std::size_t k = 0; k < corners_.size(); ++k) {
        // The turn is largest near the corner; where exactly it lies, both chords' residuals say better.
        const std::size_t corner = corners_[k].point, reach = corners_[k].chord_points;
        const std::size_t next = k + 1 < corners_.size() ? corners_[k + 1].point : block.end;
        const std::size_t from = std::max(begin, corner - std::min(corner - block.begin, reach));
        const std::size_t to = std::min(next, corner + reach);
        if (to < from + 2 * shortest_chord) continue;
        const Break bend = best_break(points_, {from, to});
        // On a round wall chords turn as well, but a parabola describes it better than two lines do.
        const NormalForm line = quick_fit(points_.moments({from, to})).line;
        if (squares_left_by_parabola_m2(points_, {from, to}, line) < bend.squares_m2) continue;
        const std::size_t end = bend.index;
        if (end <= begin) continue;
        split_rest({begin, end});
        begin = end;
    }
    split_rest({begin, block.end});
}

}  // namespace loopline::lines
