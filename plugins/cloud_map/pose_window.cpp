#include "cloud_map/pose_window.h"

#include <algorithm>
#include <cmath>

namespace loopline::cloud_map {

void PoseWindow::add(const StampedPose3& pose) {
    if (!pose.T_map_base.translation_m.allFinite() || !pose.T_map_base.rotation.coeffs().allFinite()) return;
    if (!poses_.empty() && pose.stamp_ns <= poses_.back().stamp_ns) poses_.clear();
    poses_.push_back(pose);
}

void PoseWindow::forget_before(StampNs stamp_ns) {
    while (poses_.size() > 2 && poses_[1].stamp_ns <= stamp_ns) poses_.pop_front();
}

/// Whether there is motion from pose `first` to the next one.
bool PoseWindow::joined(std::size_t first) const {
    return first + 1 < poses_.size() &&
           seconds_between(poses_[first].stamp_ns, poses_[first + 1].stamp_ns) <= max_gap_s_;
}

std::optional<Pose3> PoseWindow::at(StampNs stamp_ns) const {
    if (poses_.empty()) return std::nullopt;
    const auto after =
        std::upper_bound(poses_.begin(), poses_.end(), stamp_ns,
                         [](StampNs t, const StampedPose3& pose) { return t < pose.stamp_ns; });
    const std::size_t right = static_cast<std::size_t>(after - poses_.begin());
    std::size_t near = right == 0 ? 0 : right - 1;
    if (right > 0 && joined(right - 1)) {
        const ScrewSegment between(poses_[near].stamp_ns, poses_[near].T_map_base, poses_[right].stamp_ns,
                                   poses_[right].T_map_base);
        return between.at(stamp_ns);
    }
    if (right > 0 && right < poses_.size() &&
        poses_[right].stamp_ns - stamp_ns < stamp_ns - poses_[near].stamp_ns)
        near = right;
    if (std::abs(seconds_between(poses_[near].stamp_ns, stamp_ns)) > max_gap_s_) return std::nullopt;
    const std::size_t first = near > 0 && joined(near - 1) ? near - 1 : near;
    if (!joined(first)) return poses_[near].T_map_base;
    return ScrewSegment(poses_[first].stamp_ns, poses_[first].T_map_base, poses_[first + 1].stamp_ns,
                        poses_[first + 1].T_map_base)
        .at(stamp_ns);
}

}  // namespace loopline::cloud_map
