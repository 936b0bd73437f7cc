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

std::size_t best_break(const ScanPoints& points, const Interval& run) {
    const auto cost_m2 = [&](std::size_t b) {
        return squares_m2(points.moments({run.begin, b})) + squares_m2(points.moments({b, run.end}));
    };
    // Coarse to fine: the cost falls towards a corner over the whole length of both sides.
    std::size_t best = run.begin + run.size() / 2;
    double least_m2 = cost_m2(best);
    std::size_t low = run.begin + 1, high = run.end - 1;
    for (std::size_t stride = std::max<std::size_t>(1, run.size() / 16);;
         stride = std::max<std::size_t>(1, stride / 4)) {
        for (std::size_t b = low; b <= high; b += stride) {
            const double c = cost_m2(b);
            if (c < least_m2) {
                least_m2 = c;
                best = b;
            }
        }
        if (stride == 1) return best;
        low = std::max(run.begin + 1, best - std::min(best, stride));
        high = std::min(run.end - 1, best + stride);
    }
}

void split_until_straight(const ScanPoints& points, const Interval& run, const NoiseModel& noise,
                          double max_bow, std::vector<Piece>& pieces, std::vector<Interval>& stack) {
    const auto straight = [&](const Interval& part) {
        return part.size() < 3 || straightness(points, part, noise, max_bow).shape == Shape::straight;
    };
    stack.clear();
    stack.push_back(run);
    while (!stack.empty()) {
        const Interval part = stack.back();
        stack.pop_back();
        if (part.size() < 3) continue;
        const Straightness shape = straightness(points, part, noise, max_bow);
        if (shape.shape == Shape::straight) {
            pieces.push_back({part, shape, false});
            continue;
        }
        // A wall with the first points of the next looks like a bend too: two lines have precedence.
        const std::size_t middle = best_break(points, part);
        const Interval before{part.begin, middle}, after{middle, part.end};
        if (shape.shape == Shape::bent && part.size() > 3 && smooth_bend(points, part, noise, shape.fit) &&
            !(straight(before) && straight(after))) {
            pieces.push_back({part, shape, true});
            continue;
        }
        stack.push_back(after);
        stack.push_back(before);
    }
}

}  // namespace loopline::lines
