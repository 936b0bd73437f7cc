#include "lines/incremental.h"

#include <algorithm>
#include <cmath>

namespace loopline::lines {
namespace {
constexpr std::size_t seed_points = 5;
constexpr double gate_sigmas2 = 9;
}  // namespace

bool Incremental::lies_on(const QuickFit& fit, double count, std::size_t point) const {
    const ScanPoint p = points_[point];
    const double d_m = fit.line.distance_m(p.x_m, p.y_m), t_m = fit.line.along_m(p.x_m, p.y_m);
    const double cos2_incidence = std::max(0.0, 1 - t_m * t_m / p.squared_range_m2());
    const double own_m2 = noise_.variance_m2(cos2_incidence, t_m);
    // The line's own uncertainty where the point is: known at its middle, growing with the square of the
    // distance.
    const double half_m = std::sqrt(3 * fit.along_m2);
    const double beyond_m = half_m + std::sqrt(points_.squared_distance_m2(point - 1, point));
    const double line_m2 = own_m2 / count * (1 + beyond_m * beyond_m / std::max(fit.along_m2, 1e-12));
    return d_m * d_m <= gate_sigmas2 * (own_m2 + line_m2);
}

std::size_t Incremental::grow(const Interval& seed, std::size_t block_end) const {
    Interval line = seed;
    while (line.end < block_end) {
        const QuickFit fit = quick_fit(points_.moments(line));
        const double count = static_cast<double>(line.size());
        if (lies_on(fit, count, line.end)) {
            ++line.end;
        } else if (line.end + 1 < block_end && lies_on(fit, count, line.end + 1)) {
            line.end += 2;  // a single beam astray ends no line
        } else {
            break;
        }
    }
    return line.end;
}

void Incremental::split(const Interval& block) {
    std::size_t begin = block.begin;
    while (begin + seed_points <= block.end) {
        const Interval seed{begin, begin + seed_points};
        if (straightness(points_, seed, noise_, parameters_.max_bow).shape != Shape::straight) {
            ++begin;
            continue;
        }
        const Interval run{begin, grow(seed, block.end)};
        const Straightness shape = straightness(points_, run, noise_, parameters_.max_bow);
        // What grew into a bend is no line, but tells its neighbours that they may be chords.
        const bool straight = shape.shape == Shape::straight;
        if ((straight || shape.shape == Shape::bent) && splitter_.large_enough(points_, run))
            pieces_.push_back({run, shape, !straight, {}});
        begin = run.end;
    }
}

}  // namespace loopline::lines
