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

/// Number of points and their mean slope, ring by ring.
struct RingFigures {
    std::vector<std::uint32_t> count;
    std::vector<double> slope;
    double part_within = 0;  ///< of the variance of all slopes that is left within rings

    RingFigures(const std::vector<BeamDirection>& directions, const RingsOfCloud& found)
        : count(found.rings, 0), slope(found.rings, 0) {
        double sum = 0, squares = 0;
        for (std::size_t i = 0; i < directions.size(); ++i) {
            const double s = directions[i].slope;
            ++count[found.ring_of_point[i]];
            slope[found.ring_of_point[i]] += s;
            sum += s;
            squares += s * s;
        }
        double between = 0;
        for (std::size_t r = 0; r < found.rings; ++r) {
            if (count[r] > 0) slope[r] /= count[r];
            between += count[r] * slope[r] * slope[r];
        }
        const double all = squares - sum * sum / std::max<double>(static_cast<double>(directions.size()), 1);
        part_within = all > 0 ? (squares - between) / all : 1;
    }
};

bool earlier(const SpinningPoint& a, const SpinningPoint& b) {
    return a.time_s < b.time_s;
}

/// For points that are nearly in order: each moves by a few places, if at all.
void sort_by_insertion(SpinningPoint* begin, SpinningPoint* end) {
    for (SpinningPoint* p = begin + 1; p < end; ++p) {
        if (!earlier(p[0], p[-1])) continue;
        const SpinningPoint moved = *p;
        SpinningPoint* place = p;
        for (; place > begin && earlier(moved, place[-1]); --place) *place = place[-1];
        *place = moved;
    }
}

/// A ring is stored along the azimuth, either way and from anywhere: turned to the order of times.
void sort_by_time(SpinningPoint* begin, SpinningPoint* end) {
    if (end - begin < 2) return;
    std::ptrdiff_t falls = 0;
    for (const SpinningPoint* p = begin + 1; p < end; ++p) falls += earlier(p[0], p[-1]);
    if (2 * falls > end - begin) std::reverse(begin, end);
    SpinningPoint* first = begin;
    float deepest_fall_s = 0;
    falls = 0;
    for (SpinningPoint* p = begin + 1; p < end; ++p) {
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

/// From the highest ring to the lowest, each in the order of its times.
void sort_into(const std::vector<Eigen::Vector3f>& points_m, const std::vector<BeamDirection>& directions,
               const RingsOfCloud& found, const SweepConvention& convention, SpinningScan& scan) {
    const RingFigures figures(directions, found);
    std::vector<std::size_t> order(found.rings);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return figures.slope[a] > figures.slope[b]; });
    std::vector<std::uint32_t> next(found.rings);
    std::uint32_t begin = 0;
    scan.ring_begin.clear();
    for (const std::size_t ring : order) {
        scan.ring_begin.push_back(begin);
        next[ring] = begin;
        begin += figures.count[ring];
    }
    scan.ring_begin.push_back(begin);
    scan.points.resize(points_m.size());
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        const Eigen::Vector3f& p = points_m[i];
        scan.points[next[found.ring_of_point[i]]++] = {
            p.x(), p.y(), p.z(),
            static_cast<float>(time_of_azimuth_s(convention, directions[i].azimuth_rad))};
    }
    for (std::size_t r = 0; r < found.rings; ++r)
        sort_by_time(scan.points.data() + scan.ring_begin[r], scan.points.data() + scan.ring_begin[r + 1]);
}

}  // namespace

double time_of_azimuth_s(const SweepConvention& convention, double azimuth_rad) {
    const double turned_rad = (azimuth_rad - convention.first_azimuth_rad) * (convention.clockwise ? -1 : 1);
    const double turns = turned_rad / (2 * M_PI);
    return convention.sweep_s * (turns - std::floor(turns) - convention.stamp_part);
}

std::vector<BeamDirection> directions_of(const std::vector<Eigen::Vector3f>& points_m) {
    std::vector<BeamDirection> directions(points_m.size());
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        const Eigen::Vector3f& p = points_m[i];
        directions[i] = {std::atan2(p.y(), p.x()), p.z() / std::sqrt(p.x() * p.x() + p.y() * p.y())};
    }
    return directions;
}

RingsOfCloud rings_by_order(const std::vector<BeamDirection>& directions) {
    RingsOfCloud found;
    found.ring_of_point.reserve(directions.size());
    std::size_t ring = 0;
    float last_rad = 0;
    for (const BeamDirection& direction : directions) {
        const float azimuth_rad = direction.azimuth_rad + (direction.azimuth_rad < 0 ? 2 * pi : 0);
        if (azimuth_rad < last_rad - pi) ++ring;
        // A beam may waver about the place where rings begin: a leap to the end of the ring is a step back.
        if (azimuth_rad < last_rad + 1.8f * pi) last_rad = azimuth_rad;
        if (ring >= most_rings) return {};
        found.ring_of_point.push_back(static_cast<std::uint16_t>(ring));
    }
    found.rings = ring + 1;
    // The last ring may go on a little beyond the place where it began.
    while (found.rings > 1 && count_of_last(found) < fewest_points) {
        for (std::uint16_t& r : found.ring_of_point)
            r = std::min(r, static_cast<std::uint16_t>(found.rings - 2));
        --found.rings;
    }
    if (found.rings < fewest_rings || RingFigures(directions, found).part_within > 0.1) return {};
    return found;
}

RingsOfCloud rings_by_elevation(const std::vector<BeamDirection>& directions, std::size_t bands) {
    if (directions.empty()) return {};
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
    RingsOfCloud found;
    found.rings = borders.size() + 1;
    for (const BeamDirection& direction : directions) {
        const auto below =
            std::lower_bound(borders.begin(), borders.end(), direction.slope) - borders.begin();
        found.ring_of_point.push_back(
            static_cast<std::uint16_t>(found.rings - 1 - static_cast<std::size_t>(below)));
    }
    return found;
}

void read_cloud(const std::vector<Eigen::Vector3f>& points_m, const SweepConvention& convention,
                SpinningScan& scan) {
    const std::vector<BeamDirection> directions = directions_of(points_m);
    RingsOfCloud found = rings_by_order(directions);
    if (found.rings == 0) found = rings_by_elevation(directions);
    sort_into(points_m, directions, found, convention, scan);
    scan.begin_s = -convention.stamp_part * convention.sweep_s;
    scan.end_s = (1 - convention.stamp_part) * convention.sweep_s;
}

}  // namespace loopline::lidar
