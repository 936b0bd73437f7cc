#include "lines/splitting.h"

#include <algorithm>
#include <cmath>

#include "lines/vectorised.h"

namespace loopline::lines {
namespace {

constexpr std::size_t coarse_breaks = 16;
constexpr double left_by_a_step = 0.25;  // of the mean square, at most

/// Sum of squared distances from the least-squares line.
inline double squares_m2(const Moments& m, double inverse_n) {
    const double mean_x = m.x * inverse_n, mean_y = m.y * inverse_n;
    const double sxx = m.xx - m.x * mean_x, syy = m.yy - m.y * mean_y, sxy = m.xy - m.x * mean_y;
    const double difference = sxx - syy, twice_sxy = sxy + sxy;
    return 0.5 * (sxx + syy - std::sqrt(difference * difference + twice_sxy * twice_sxy));
}

}  // namespace

GapSplitter::GapSplitter(const ExtractionParameters& parameters)
    : parameters_(parameters),
      shortest_(std::min(static_cast<std::size_t>(parameters.min_beams), NoiseMeter::min_points)) {}

LOOPLINE_VECTORISED void GapSplitter::split(const ScanPoints& points, const NoiseModel& noise,
                                            std::vector<Interval>& runs) {
    runs.clear();
    if (points.size() == 0) return;
    const double grazing_rad = M_PI / 2 - parameters_.max_incidence_rad - points.angle_step_rad();
    const double spacing_per_range =
        grazing_rad > 1e-3 ? points.sin_angle_step() / std::sin(grazing_rad) : 1e3;
    const double noise_m = 4 * std::sqrt(2 * noise.range_variance_m2);
    const double *const x_m = points.x_m(), *const y_m = points.y_m(), *const range_m = points.range_m();
    if (excess_m2_.size() < points.size()) {
        excess_m2_.resize(points.size());
        ends_.resize(points.size());
    }
    double* const excess_m2 = excess_m2_.data();
    const double max_gap_m = parameters_.max_gap_m;
#pragma omp simd
    for (std::size_t i = 1; i < points.size(); ++i) {
        const double dx_m = x_m[i] - x_m[i - 1], dy_m = y_m[i] - y_m[i - 1];
        const double nearer_m = range_m[i - 1] < range_m[i] ? range_m[i - 1] : range_m[i];
        const double spacing_m = nearer_m * spacing_per_range;
        const double allowed_m = noise_m + (spacing_m < max_gap_m ? max_gap_m : spacing_m);
        excess_m2[i] = dx_m * dx_m + dy_m * dy_m - allowed_m * allowed_m;
    }
    // In clutter gaps are frequent and can't be predicted: no branch.
    std::size_t *const ends = ends_.data(), *end = ends;
    for (std::size_t i = 1; i < points.size(); ++i) {
        *end = i;
        end += excess_m2[i] > 0;
    }
    *end++ = points.size();
    runs.resize(static_cast<std::size_t>(end - ends));
    Interval* run = runs.data();
    std::size_t begin = 0;
    for (const std::size_t* e = ends; e < end; ++e) {
        run->begin = begin;
        run->end = *e;
        run += *e - begin >= shortest_;
        begin = *e;
    }
    runs.resize(static_cast<std::size_t>(run - runs.data()));
}

LOOPLINE_VECTORISED Break best_break(const ScanPoints& points, const Interval& run) {
    const Moments begin = points.sums_before(run.begin), end = points.sums_before(run.end);
    const Moments* const sums = &points.sums_before(run.begin);
    const double* const inverse = points.inverse();
    const std::size_t size = run.size();
    const auto squares_at = [=](std::size_t b) {
        return squares_m2(sums[b] - begin, inverse[b]) + squares_m2(end - sums[b], inverse[size - b]);
    };
    Break best{run.begin + size / 2, squares_at(size / 2)};
    // Coarse to fine: the squares fall towards a corner over the whole length of both sides.
    std::size_t stride = std::max<std::size_t>(1, size / coarse_breaks), low = 1, high = size - 1;
    for (;;) {
        double squares[2 * coarse_breaks], least = best.squares_m2;
        const std::size_t count = (high - low) / stride + 1;
#pragma omp simd reduction(min : least)
        for (std::size_t k = 0; k < count; ++k) {
            squares[k] = squares_at(low + k * stride);
            least = squares[k] < least ? squares[k] : least;
        }
        for (std::size_t k = count; k-- > 0;)
            if (squares[k] == least) best.index = run.begin + low + k * stride;
        best.squares_m2 = least;
        if (stride == 1) return best;
        // Between the neighbours of the best one.
        const std::size_t middle = best.index - run.begin;
        low = middle > stride ? middle - stride : 1;
        high = std::min(size - 1, middle + stride);
        stride = std::max<std::size_t>(1, stride / 4);
    }
}

bool hides_a_step(const ScanPoints& points, const Interval& run, const Straightness& shape,
                  const NoiseModel& noise) {
    const double n = static_cast<double>(run.size()), mean_square_m2 = shape.fit.across_m2;
    if (run.size() < 6 ||
        mean_square_m2 * noise.factor < chi2_per_degree_limit(run.size() - 2) * shape.variance_m2)
        return false;
    return best_break(points, run).squares_m2 / (n - 4) < left_by_a_step * mean_square_m2 * n / (n - 2);
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

/// A wall with the first points of the next looks like a bend too. It is one if a parabola leaves no more
/// than noise, and less than two lines do where those would be straight.
bool Splitter::is_arc(const ScanPoints& points, const Interval& run, const Straightness& shape,
                      const Break& corner, const NoiseModel& noise) const {
    if (shape.shape != Shape::bent) return false;
    const std::size_t degrees = run.size() - 3;
    const double squares_m2 = squares_left_by_parabola_m2(points, run, shape.fit.line);
    if (squares_m2 > chi2_per_degree_limit(degrees) * static_cast<double>(degrees) * shape.variance_m2)
        return false;
    return squares_m2 + 2 * shape.variance_m2 < corner.squares_m2 ||
           !straight_or_small(points, {run.begin, corner.index}, noise) ||
           !straight_or_small(points, {corner.index, run.end}, noise);
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
        if (shape.shape == Shape::straight && !hides_a_step(points, part, shape, noise)) {
            if (large_enough(points, part)) pieces.push_back({part, shape, false, {}});
            continue;
        }
        const Break corner = best_break(points, part);
        if (is_arc(points, part, shape, corner, noise)) {
            pieces.push_back({part, shape, true, {}});
            continue;
        }
        stack_.push_back({corner.index, part.end});
        stack_.push_back({part.begin, corner.index});
    }
}

}  // namespace loopline::lines
