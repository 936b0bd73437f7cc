#include "grid_map/surface_index.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace loopline::grid_map {
namespace {

constexpr int beside = 4;
using FourFloats = float __attribute__((vector_size(4 * beside)));
using FourInts = std::int32_t __attribute__((vector_size(4 * beside)));

constexpr std::size_t repeated = 2;  ///< slots that follow the last one again, so that three are in a row

FourFloats load(const float* from) {
    FourFloats v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

float sum(const FourFloats& v) {
    return (v[0] + v[1]) + (v[2] + v[3]);
}

}  // namespace

void SurfaceIndex::clear() {
    points_.clear();
    for (auto* values : {&x_, &y_, &nx_, &ny_}) values->clear();
}

void SurfaceIndex::add(const Frame& frame, const Pose2& T_map_base) {
    const auto c = static_cast<float>(std::cos(T_map_base.phi_rad)),
               s = static_cast<float>(std::sin(T_map_base.phi_rad)), x = static_cast<float>(T_map_base.x_m),
               y = static_cast<float>(T_map_base.y_m);
    for (const SurfacePoint& p : frame.points)
        if (p.has_normal())
            points_.push_back({x + c * p.p_base_m.x() - s * p.p_base_m.y(),
                               y + s * p.p_base_m.x() + c * p.p_base_m.y(),
                               c * p.normal_base.x() - s * p.normal_base.y(),
                               s * p.normal_base.x() + c * p.normal_base.y()});
}

void SurfaceIndex::finish() {
    begin_.assign(slots_ + repeated + 1, 0);
    thread_local std::vector<std::uint32_t> slots, next;
    slots.clear();
    for (const Point& p : points_) {
        const std::size_t slot = slot_of(bucket(p.x), bucket(p.y));
        slots.push_back(static_cast<std::uint32_t>(slot));
        ++begin_[slot + 1];
    }
    for (std::size_t k = 0; k < repeated; ++k) begin_[slots_ + k + 1] = begin_[k + 1];
    for (std::size_t k = 0; k < slots_ + repeated; ++k) begin_[k + 1] += begin_[k];
    // A vector that begins at the last point reads beyond it.
    const std::size_t size = begin_.back() + beside;
    for (auto* values : {&x_, &y_, &nx_, &ny_}) values->assign(size, 0);
    next.assign(begin_.begin(), begin_.end() - 1);
    const auto put = [this](std::size_t slot, const Point& p) {
        const std::size_t at = next[slot]++;
        x_[at] = p.x;
        y_[at] = p.y;
        nx_[at] = p.nx;
        ny_[at] = p.ny;
    };
    for (std::size_t k = 0; k < points_.size(); ++k) {
        put(slots[k], points_[k]);
        if (slots[k] < repeated) put(slots_ + slots[k], points_[k]);
    }
}

std::array<SurfaceIndex::Range, 3> SurfaceIndex::around(double x_m, double y_m) const {
    const int bx = bucket(x_m), by = bucket(y_m);
    std::array<Range, 3> ranges;
    for (int row = 0; row < 3; ++row) {
        const std::size_t first = slot_of(bx - 1, by - 1 + row);
        ranges[static_cast<std::size_t>(row)] = {begin_[first], begin_[first + 3]};
    }
    return ranges;
}

SurfaceIndex::Nearby SurfaceIndex::nearest(double x_m, double y_m, float normal_x, float normal_y,
                                           float reach_m) const {
    constexpr float facing = 0.7F, continues = 0.8F;
    constexpr float far = std::numeric_limits<float>::max();
    constexpr FourInts lane = {0, 1, 2, 3};
    const auto px = static_cast<float>(x_m), py = static_cast<float>(y_m);
    const std::array<Range, 3> ranges = around(x_m, y_m);

    const float reach2 = reach_m * reach_m;
    FourFloats nearest2 = {reach2, reach2, reach2, reach2};
    FourInts nearest = {-1, -1, -1, -1};
    for (const Range& range : ranges)
        for (std::uint32_t k = range.begin; k < range.end; k += beside) {
            const FourFloats dx = load(&x_[k]) - px, dy = load(&y_[k]) - py, d2 = dx * dx + dy * dy,
                             along = load(&nx_[k]) * normal_x + load(&ny_[k]) * normal_y;
            const FourInts index = lane + static_cast<std::int32_t>(k);
            const FourInts nearer =
                (d2 < nearest2) & (along > facing) & (index < static_cast<std::int32_t>(range.end));
            nearest2 = nearer ? d2 : nearest2;
            nearest = nearer ? index : nearest;
        }
    std::int32_t best = -1;
    float best2 = far;
    for (int k = 0; k < beside; ++k)
        if (nearest[k] >= 0 && (nearest2[k] < best2 || (nearest2[k] == best2 && nearest[k] < best))) {
            best = nearest[k];
            best2 = nearest2[k];
        }
    Nearby result;
    if (best < 0) return result;

    // A point's weight falls like a Gaussian of its distance beyond the nearest one, but is quick to compute.
    const auto at = static_cast<std::size_t>(best);
    const float nearest_nx = nx_[at], nearest_ny = ny_[at];
    const auto per_scale2 = static_cast<float>(0.125 / (spacing_m_ * spacing_m_));
    FourFloats sum_w{}, sum_x{}, sum_y{}, sum_nx{}, sum_ny{};
    for (const Range& range : ranges)
        for (std::uint32_t k = range.begin; k < range.end; k += beside) {
            const FourFloats dx = load(&x_[k]) - px, dy = load(&y_[k]) - py, nx = load(&nx_[k]),
                             ny = load(&ny_[k]), d2 = dx * dx + dy * dy;
            const FourInts counts =
                (d2 < reach2) & (nx * normal_x + ny * normal_y > facing) &
                (nx * nearest_nx + ny * nearest_ny >= continues) &
                (lane + static_cast<std::int32_t>(k) < static_cast<std::int32_t>(range.end));
            const FourFloats part = 1 - (d2 - best2) * per_scale2;
            const FourInts near = counts & (part > 0);
            const FourFloats square = part * part, w = near ? square * square : FourFloats{};
            sum_w += w;
            sum_x += w * dx;
            sum_y += w * dy;
            sum_nx += w * nx;
            sum_ny += w * ny;
        }
    const float per_weight = 1 / sum(sum_w);
    result.found = true;
    result.dx_m = sum(sum_x) * per_weight;
    result.dy_m = sum(sum_y) * per_weight;
    result.nx = sum(sum_nx);
    result.ny = sum(sum_ny);
    return result;
}

}  // namespace loopline::grid_map
