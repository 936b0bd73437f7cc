#include "grid_slam/frame_list.h"

namespace loopline::grid_slam {

void FrameList::push_back(const grid_map::Frame& frame) {
    for (const grid_map::SurfacePoint& p : frame.points)
        points_.push_back({p.p_base_m.x(), p.p_base_m.y(), p.normal_base.x(), p.normal_base.y()});
    end_.push_back(points_.size());
    p_base_sensor_m_.push_back(frame.p_base_sensor_m);
}

const grid_map::Frame& FrameList::operator[](std::uint32_t index) const {
    if (cache_.empty()) cache_.resize(cached_frames);
    Cached& slot = cache_[index % cached_frames];
    if (slot.filled && slot.frame == index) return slot.content;
    const std::uint64_t first = index == 0 ? 0 : end_[index - 1];
    slot.frame = index;
    slot.content.p_base_sensor_m = p_base_sensor_m_[index];
    slot.content.points.clear();
    slot.content.points.reserve(end_[index] - first);
    points_.for_each(first, end_[index], [&slot](const Point& p) {
        slot.content.points.push_back({{p[0], p[1]}, {p[2], p[3]}});
    });
    slot.filled = true;
    return slot.content;
}

}  // namespace loopline::grid_slam
