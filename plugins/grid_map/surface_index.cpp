#include "grid_map/surface_index.h"

#include <cmath>

namespace loopline::grid_map {

void SurfaceIndex::clear() {
    points_.clear();
    sorted_.clear();
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
    begin_.assign(slots_ + 1, 0);
    for (const Point& p : points_) ++begin_[slot_of(bucket(p.x), bucket(p.y)) + 1];
    for (std::size_t k = 0; k < slots_; ++k) begin_[k + 1] += begin_[k];
    sorted_.resize(points_.size());
    thread_local std::vector<std::uint32_t> next;
    next.assign(begin_.begin(), begin_.end() - 1);
    for (const Point& p : points_) sorted_[next[slot_of(bucket(p.x), bucket(p.y))]++] = p;
}

}  // namespace loopline::grid_map
