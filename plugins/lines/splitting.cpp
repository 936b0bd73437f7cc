#include "lines/splitting.h"

#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {

/// Sum of squared distances from the least-squares line.
double squares_m2(const Moments& m) {
    if (m.n < 3) return 0;
    const double inverse_n = 1 / m.n;
    const double sxx = m.xx - m.x * m.x * inverse_n, syy = m.yy - m.y * m.y * inverse_n;
    const double sxy = m.xy - m.x * m.y * inverse_n;
    const double difference = sxx - syy;
    return 0.5 * (sxx + syy - std::sqrt(difference * difference + 4 * sxy * sxy));
}

}  // namespace

void split_at_gaps(const ScanPoints& points, const ExtractionParameters& parameters, const NoiseModel& noise,
                   std::vector<Interval>& runs) {
    runs.clear();
    if (points.size() == 0) return;
    const double grazing_rad = M_PI / 2 - parameters.max_incidence_rad - points.angle_step_rad();
    const double spacing_per_range =
        grazing_rad > 1e-3 ? points.sin_angle_step() / std::sin(grazing_rad) : 1e3;
    const double noise_m = 4 * std::sqrt(2 * noise.range_variance_m2);
    std::size_t begin = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
        const double nearer_m = std::min(points[i - 1].range_m, points[i].range_m);
        const double allowed_m = noise_m + std::max(parameters.max_gap_m, nearer_m * spacing_per_range);
        if (points.squared_distance_m2(i - 1, i) <= allowed_m * allowed_m) continue;
        runs.push_back({begin, i});
        begin = i;
    }
    runs.push_back({begin, points.size()});
}

Break best_break(const ScanPoints& points, const Interval& run) {
    const auto squares_at = [&](std::size_t b) {
        return squares_m2(points.moments({run.begin, b})) + squares_m2(points.moments({b, run.end}));
    };
    // Coarse to fine: the squares fall towards a corner over the whole length of both sides.
    Break best{run.begin + run.size() / 2, squares_at(run.begin + run.size() / 2)};
    std::size_t low = run.begin + 1, high = run.end - 1;
    for (std::size_t stride = std::max<std::size_t>(1, run.size() / 16);;
         stride = std::max<std::size_t>(1, stride / 4)) {
        for (std::size_t b = low; b <= high; b += stride) {
            const double squares = squares_at(b);
            if (squares < best.squares_m2) best = {b, squares};
        }
        if (stride == 1) return best;
        low = std::max(run.begin + 1, best.index - std::min(best.index, stride));
        high = std::min(run.end - 1, best.index + stride);
    }
}

bool Splitter::large_enough(const ScanPoints& points, const Interval& run) const {
    return run.size() >= static_cast<std::size_t>(parameters_.min_beams) &&
           points.squared_distance_m2(run.begin, run.end - 1) >=
               parameters_.min_length_m * parameters_.min_length_m;
}

bool Splitter::straight_or_small(const ScanPoints& points, const Interval& run,
                                 const NoiseModel& noise) const {
    return !large_enough(points, run) ||
           straightness(points, run, noise, parameters_.max_bow).shape == Shape::straight;
}

void Splitter::split(const ScanPoints& points, const Interval& run, const NoiseModel& noise,
                     std::vector<Piece>& pieces) {
    stack_.clear();
    stack_.push_back(run);
    while (!stack_.empty()) {
        const Interval part = stack_.back();
        stack_.pop_back();
        // A path that turns back has its ends together: only what can't be split any further is judged by
        // them.
        if (part.size() < static_cast<std::size_t>(parameters_.min_beams)) continue;
        const Straightness shape = straightness(points, part, noise, parameters_.max_bow);
        if (shape.shape == Shape::straight) {
            if (large_enough(points, part)) pieces.push_back({part, shape, false, {}});
            continue;
        }
        const Break corner = best_break(points, part);
        const Interval before{part.begin, corner.index}, after{corner.index, part.end};
        // A wall with the first points of the next looks like a bend too. It is one if a parabola leaves no
        // more than noise, and less than two lines do where those would be straight.
        if (shape.shape == Shape::bent) {
            const double n = static_cast<double>(part.size());
            const double variance_m2 = noise.mean_variance_m2(points.moments(part), shape.fit.line.rho_m);
            const double squares_m2 = squares_left_by_parabola_m2(points, part, shape.fit.line);
            if (squares_m2 <= chi2_per_degree_limit(n - 3) * (n - 3) * variance_m2 &&
                (squares_m2 + 2 * variance_m2 < corner.squares_m2 ||
                 !straight_or_small(points, before, noise) || !straight_or_small(points, after, noise))) {
                pieces.push_back({part, shape, true, {}});
                continue;
            }
        }
        stack_.push_back(after);
        stack_.push_back(before);
    }
}

}  // namespace loopline::lines
