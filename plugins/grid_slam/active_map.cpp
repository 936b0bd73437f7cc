#include "grid_slam/active_map.h"

#include <cmath>

namespace loopline::grid_slam {

void ActiveMap::draw(const MapFrames& map, std::uint32_t frame) {
    in_grid_[frame] = true;
    T_grid_base_[frame] = map.poses[frame];
    grid_.insert(map.frames[frame], map.poses[frame]);
}

void ActiveMap::wipe(const MapFrames& map, std::uint32_t frame) {
    in_grid_[frame] = false;
    grid_.remove(map.frames[frame], T_grid_base_[frame]);
}

bool ActiveMap::has_moved(const MapFrames& map, std::uint32_t frame) const {
    const Pose2 &then = T_grid_base_[frame], &now = map.poses[frame];
    return (then.translation() - now.translation()).norm() > settings_.moved_m ||
           std::abs(wrap_to_pi(then.phi_rad - now.phi_rad)) > settings_.moved_rad;
}

void ActiveMap::add(const MapFrames& map, std::uint32_t frame) {
    in_grid_.resize(map.size(), false);
    T_grid_base_.resize(map.size());
    draw(map, frame);
    active_.push_back(frame);
}

void ActiveMap::choose(const MapFrames& map, const Neighbourhood& neighbourhood, std::uint32_t from) {
    const double limit_m2 = settings_.sigma_m * settings_.sigma_m;
    relative_uncertainty(neighbourhood, map.poses, from, limit_m2, uncertainty_);
    const auto belongs = [&](std::uint32_t frame) {
        return uncertainty_.variance_m2[frame] < limit_m2 && map.distance_m(frame, from) < settings_.radius_m;
    };
    for (const std::uint32_t frame : active_)
        if (!belongs(frame) || has_moved(map, frame)) wipe(map, frame);
    active_.clear();
    for (std::uint32_t frame = 0; frame < map.size(); ++frame) {
        if (!belongs(frame)) continue;
        if (!in_grid_[frame]) draw(map, frame);
        active_.push_back(frame);
    }
    grid_.settle();
}

}  // namespace loopline::grid_slam
