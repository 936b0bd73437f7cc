#include "lidar/cloud_rings.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace loopline::lidar {
namespace {

constexpr std::size_t fewest_rings = 4, most_rings = 256;
constexpr std::size_t fewest_points = 16;  ///< of a ring that ends a cloud
constexpr auto pi = static_cast<float>(M_PI);

std::size_t count_of_last(const RingsOfCloud& found) {
    std::size_t count = 0;
    for (auto r = found.ring_of_point.rbegin(); r != found.ring_of_point.rend() && *r + 1u == found.rings;
         ++r)
        ++count;
    return count;
}

/// Counts points of rings and takes their mean slopes. Returns the part of the variance of all slopes that is
/// left within rings.
double weigh(const std::vector<BeamDirection>& directions, RingsOfCloud& found) {
    found.count.assign(found.rings, 0);
    found.slope.assign(found.rings, 0);
    double squares = 0;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const double slope = directions[i].slope;
        ++found.count[found.ring_of_point[i]];
        found.slope[found.ring_of_point[i]] += slope;
        squares += slope * slope;
    }
    double sum = 0, between = 0;
    for (std::size_t r = 0; r < found.rings; ++r) {
        sum += found.slope[r];
        if (found.count[r] > 0) found.slope[r] /= found.count[r];
        between += found.count[r] * found.slope[r] * found.slope[r];
    }
    const double all = squares - sum * sum / std::max<double>(static_cast<double>(directions.size()), 1);
    return all > 0 ? (squares - between) / all : 1;
}

/// Abramowitz and Stegun 1964, 4.4.49: the error is below 1e-5.
float quick_atan2(float y, float x) {
    const float ax = std::abs(x), ay = std::abs(y);
    const float z = std::min(ax, ay) / std::max(ax, ay), z2 = z * z;
    const float octant =
        z * (0.9998660f + z2 * (-0.3302995f + z2 * (0.1801410f + z2 * (-0.0851330f + z2 * 0.0208351f))));
    const float quadrant = ay > ax ? pi / 2 - octant : octant;
    const float half = x < 0 ? pi - quadrant : quadrant;
    return y < 0 ? -half : half;
}

/// A time as the part of a turn that is left after whole turns.
class SweepTimes {
 public:
    explicit SweepTimes(const SweepConvention& c)
        : turns_per_rad_(static_cast<float>((c.clockwise ? -1 : 1) / (2 * M_PI))),
          first_(static_cast<float>(c.first_azimuth_rad) * turns_per_rad_),
          stamp_part_(static_cast<float>(c.stamp_part)),
          sweep_s_(static_cast<float>(c.sweep_s)) {}

    float at(float azimuth_rad) const {
        float turns = azimuth_rad * turns_per_rad_ - first_;
        turns -= static_cast<float>(static_cast<int>(turns));
        return sweep_s_ * ((turns < 0 ? turns + 1 : turns) - stamp_part_);
    }

 private:
    float turns_per_rad_, first_, stamp_part_, sweep_s_;
};

bool earlier(const SpinningPoint& a, const SpinningPoint& b) {
    return a.time_s < b.time_s;
}

/// A point that knows its place in the cloud.
struct TracedPoint : SpinningPoint {
    std::uint32_t source = 0;
};

/// For points that are nearly in order: each moves by a few places, if at all.
template <class Point>
void sort_by_insertion(Point* begin, Point* end) {
    for (Point* p = begin + 1; p < end; ++p) {
        if (!earlier(p[0], p[-1])) continue;
        const Point moved = *p;
        Point* place = p;
        for (; place > begin && earlier(moved, place[-1]); --place) *place = place[-1];
        *place = moved;
    }
}

/// A ring is stored along the azimuth, either way and from anywhere: turned to the order of times.
template <class Point>
void sort_by_time(Point* begin, Point* end) {
    if (end - begin < 2) return;
    std::ptrdiff_t falls = 0;
    for (const Point* p = begin + 1; p < end; ++p) falls += earlier(p[0], p[-1]);
    if (2 * falls > end - begin) std::reverse(begin, end);
    Point* first = begin;
    float deepest_fall_s = 0;
    falls = 0;
    for (Point* p = begin + 1; p < end; ++p) {
        const float fall_s = p[-1].time_s - p[0].time_s;
        falls += fall_s > 0;
        if (fall_s <= deepest_fall_s) continue;
        deepest_fall_s = fall_s;
        first = p;
    }
    std::rotate(begin, first, end);
    if (8 * falls < end - begin)
        sort_by_insertion(begin, end);
    else
        std::stable_sort(begin, end, earlier);
}

}  // namespace

void find_directions(const std::vector<Eigen::Vector3f>& points_m, std::vector<BeamDirection>& directions) {
    directions.resize(points_m.size());
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        const Eigen::Vector3f& p = points_m[i];
        directions[i] = {quick_atan2(p.y(), p.x()), p.z() / std::sqrt(p.x() * p.x() + p.y() * p.y())};
    }
}

void find_rings_by_order(const std::vector<BeamDirection>& directions, RingsOfCloud& found) {
    found.rings = 0;
    found.ring_of_point.resize(directions.size());
    std::size_t ring = 0;
    float last_rad = 0;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const float azimuth_rad = directions[i].azimuth_rad + (directions[i].azimuth_rad < 0 ? 2 * pi : 0);
        if (azimuth_rad < last_rad - pi && ++ring >= most_rings) return;
        // A beam may waver about the place where rings begin: a leap to the end of the ring is a step back.
        if (azimuth_rad < last_rad + 1.8f * pi) last_rad = azimuth_rad;
        found.ring_of_point[i] = static_cast<std::uint16_t>(ring);
    }
    found.rings = ring + 1;
    // The last ring may go on a little beyond the place where it began.
    while (found.rings > 1 && count_of_last(found) < fewest_points) {
        for (std::uint16_t& r : found.ring_of_point)
            r = std::min(r, static_cast<std::uint16_t>(found.rings - 2));
        --found.rings;
    }
    if (found.rings < fewest_rings || weigh(directions, found) > 0.1) found.rings = 0;
}

void find_rings_by_elevation(const std::vector<BeamDirection>& directions, RingsOfCloud& found,
                             std::size_t bands) {
    found.rings = 0;
    if (directions.empty()) return;
    constexpr float gap = 0.0007f;  // 0.04 degrees: float coordinates spread a ring by a tenth of that
    std::vector<float> sorted;
    for (const BeamDirection& direction : directions) sorted.push_back(direction.slope);
    std::sort(sorted.begin(), sorted.end());
    std::vector<float> borders;  // between clusters, from the lowest
    for (std::size_t i = 0; i + 1 < sorted.size(); ++i)
        if (sorted[i + 1] - sorted[i] > gap) borders.push_back((sorted[i] + sorted[i + 1]) / 2);
    if (borders.size() + 1 < fewest_rings || borders.size() >= most_rings) {
        borders.clear();
        const float height = sorted.back() - sorted.front();
        for (std::size_t r = 1; r < bands; ++r)
            borders.push_back(sorted.front() + height * static_cast<float>(r) / static_cast<float>(bands));
    }
    found.rings = borders.size() + 1;
    found.ring_of_point.clear();
    for (const BeamDirection& direction : directions) {
        const auto below =
            std::lower_bound(borders.begin(), borders.end(), direction.slope) - borders.begin();
        found.ring_of_point.push_back(
            static_cast<std::uint16_t>(found.rings - 1 - static_cast<std::size_t>(below)));
    }
    weigh(directions, found);
}

/// From the highest ring to the lowest, each in the order of its times.
void CloudReader::sort_into(const std::vector<Eigen::Vector3f>& points_m, const SweepConvention& convention,
                            SpinningScan& scan) {
    std::vector<std::size_t> order(found_.rings);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return found_.slope[a] > found_.slope[b]; });
    next_.resize(found_.rings);
    std::uint32_t begin = 0;
    scan.ring_begin.clear();
    for (const std::size_t ring : order) {
        scan.ring_begin.push_back(begin);
        next_[ring] = begin;
        begin += found_.count[ring];
    }
    scan.ring_begin.push_back(begin);
    scan.points.resize(points_m.size());
    const SweepTimes times(convention);
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        const Eigen::Vector3f& p = points_m[i];
        scan.points[next_[found_.ring_of_point[i]]++] = {p.x(), p.y(), p.z(),
                                                         times.at(directions_[i].azimuth_rad)};
    }
    for (std::size_t r = 0; r < found_.rings; ++r)
        sort_by_time(scan.points.data() + scan.ring_begin[r], scan.points.data() + scan.ring_begin[r + 1]);
}

/// The same order again, of the points with their places.
void CloudReader::trace(const SpinningScan& scan, const std::vector<Eigen::Vector3f>& points_m,
                        const SweepConvention& convention, std::vector<std::uint32_t>& sources) {
    std::vector<TracedPoint> traced(points_m.size());
    for (std::size_t r = 0; r < found_.rings; ++r) next_[r] -= found_.count[r];
    const SweepTimes times(convention);
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        TracedPoint& p = traced[next_[found_.ring_of_point[i]]++];
        p.time_s = times.at(directions_[i].azimuth_rad);
        p.source = static_cast<std::uint32_t>(i);
    }
    for (std::size_t r = 0; r < found_.rings; ++r)
        sort_by_time(traced.data() + scan.ring_begin[r], traced.data() + scan.ring_begin[r + 1]);
    sources.clear();
    for (const TracedPoint& p : traced) sources.push_back(p.source);
}

void CloudReader::read(const std::vector<Eigen::Vector3f>& points_m, const SweepConvention& convention,
                       SpinningScan& scan, std::vector<std::uint32_t>* sources) {
    find_directions(points_m, directions_);
    find_rings_by_order(directions_, found_);
    if (found_.rings == 0) find_rings_by_elevation(directions_, found_);
    sort_into(points_m, convention, scan);
    if (sources != nullptr) trace(scan, points_m, convention, *sources);
    scan.begin_s = -convention.stamp_part * convention.sweep_s;
    scan.end_s = (1 - convention.stamp_part) * convention.sweep_s;
}

}  // namespace loopline::lidar
