#include "lidar_mapping/sweep_mapping.h"

#include <cmath>
#include <cstdlib>

namespace loopline::lidar_mapping {

const Registration& SweepMapping::add(const lidar::SpinningScan& scan) {
    sampler_.sample(scan, settings_.sampling, settings_.map_voxel_m, points_);
    sampler_.thin_out(points_, settings_.match_voxel_m, matched_);
    const StampNs middle_ns = scan.stamp_ns + std::llround(1e9 * (scan.begin_s + scan.end_s) / 2);
    if (any_)
        last_ = register_sweep(map_, matched_,
                               predict(last_.state, seconds_between(last_ns_, middle_ns), settings_.motion),
                               settings_.registration);
    else
        last_.state = first_state(settings_.motion);
    any_ = true;
    last_ns_ = middle_ns;
    add_to_map();
    return last_;
}

void SweepMapping::add_to_map() {
    const MotionState& state = last_.state;
    points_map_m_.clear();
    for (const SweepPoint& point : points_)
        points_map_m_.push_back(state.T_map_base * undistorted(point, state.velocity));
    for (std::size_t size = 0; size < map_.sizes(); ++size)
        for (const Eigen::Vector3d& p_map_m : points_map_m_) map_.add(size, p_map_m);
    if (getenv("NOF") || (state.T_map_base.translation_m - forgot_at_m_).norm() < settings_.forget_every_m) return;
    forgot_at_m_ = state.T_map_base.translation_m;
    map_.keep_around(forgot_at_m_);
}

}  // namespace loopline::lidar_mapping
