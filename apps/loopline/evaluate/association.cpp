#include "evaluate/association.h"

#include <algorithm>
#include <cmath>

namespace loopline {

std::vector<StampedPose> way_of_point(std::vector<StampedPose> poses, const Eigen::Vector2d& point_m) {
    const Pose3 T_base_point(Pose2{point_m.x(), point_m.y(), 0});
    if (!point_m.isZero())
        for (StampedPose& pose : poses) pose.T_map_base = pose.T_map_base * T_base_point;
    return poses;
}

namespace {

constexpr double max_bridge = 10;  // of interpolation, over the greatest difference in time

/// The position at `stamp_ns`, which lies between a and b, as far as neither is too far away; else that of
/// the nearest.
Pose3 position_between(const StampedPose& a, const StampedPose& b, StampNs stamp_ns, double max_bridge_s) {
    const double before_s = seconds_between(a.stamp_ns, stamp_ns),
                 after_s = seconds_between(stamp_ns, b.stamp_ns);
    if (before_s > max_bridge_s || after_s > max_bridge_s || before_s + after_s <= 0)
        return before_s <= after_s ? a.T_map_base : b.T_map_base;
    Pose3 pose = a.T_map_base;
    pose.translation_m +=
        before_s / (before_s + after_s) * (b.T_map_base.translation_m - a.T_map_base.translation_m);
    return pose;
}

/// On the straight line and the shortest turn from a to b, if `stamp_ns` lies between them.
Pose3 pose_between(const StampedPose& a, const StampedPose& b, StampNs stamp_ns) {
    const double whole_s = seconds_between(a.stamp_ns, b.stamp_ns),
                 part = seconds_between(a.stamp_ns, stamp_ns) / whole_s;
    return {a.T_map_base.translation_m + part * (b.T_map_base.translation_m - a.T_map_base.translation_m),
            a.T_map_base.rotation.slerp(part, b.T_map_base.rotation)};
}

std::vector<PosePair> associate(const std::vector<StampedPose>& estimate,
                                const std::vector<StampedPose>& reference, double max_difference_s,
                                ReferencePoses::Kind kind) {
    const StampedPath path(reference);
    ReferencePoses poses(path, max_difference_s, kind);
    std::vector<PosePair> pairs;
    for (std::size_t i = 0; i < estimate.size(); ++i)
        if (const auto found = poses.at(estimate[i].stamp_ns))
            pairs.push_back({estimate[i].stamp_ns, i, estimate[i].T_map_base, *found});
    return pairs;
}

constexpr double same_time_s = 1e-3;  // of stamps that were rounded

}  // namespace

ReferencePoses::ReferencePoses(const StampedPath& reference, double max_difference_s, Kind kind)
    : poses_(&in_order_of_stamps(reference, sorted_)), max_difference_s_(max_difference_s), kind_(kind) {}

std::size_t ReferencePoses::not_before(StampNs stamp_ns) const {
    const auto is_it = [&](std::size_t i) {
        return i <= poses_->size() && (i == poses_->size() || poses_->stamp_ns(i) >= stamp_ns) &&
               (i == 0 || poses_->stamp_ns(i - 1) < stamp_ns);
    };
    constexpr std::size_t near_by = 8;
    for (std::size_t i = after_; i < after_ + near_by; ++i)
        if (is_it(i)) return i;
    const auto found = std::lower_bound(poses_->begin(), poses_->end(), stamp_ns,
                                        [](const auto& p, StampNs stamp) { return p.stamp_ns < stamp; });
    return static_cast<std::size_t>(found - poses_->begin());
}

std::optional<Pose3> ReferencePoses::at(StampNs stamp_ns) {
    if (poses_->empty()) return std::nullopt;
    after_ = not_before(stamp_ns);
    const StampedPose next = (*poses_)[std::min(after_, poses_->size() - 1)];
    const StampedPose previous = after_ == 0 ? next : (*poses_)[after_ - 1];
    const auto difference_s = [stamp_ns](const StampedPose& p) {
        return std::abs(seconds_between(p.stamp_ns, stamp_ns));
    };
    const StampedPose& nearest = difference_s(previous) <= difference_s(next) ? previous : next;
    if (!(difference_s(nearest) <= max_difference_s_)) return std::nullopt;
    // Before its first pose and after its last one a reference says nothing of a vehicle that moves.
    const bool outside = after_ == 0 || after_ == poses_->size();
    if (kind_ == Kind::poses_between && outside && difference_s(nearest) > same_time_s) return std::nullopt;
    if (kind_ == Kind::poses_between && previous.stamp_ns < stamp_ns && stamp_ns < next.stamp_ns &&
        difference_s(previous) <= max_difference_s_ && difference_s(next) <= max_difference_s_)
        return pose_between(previous, next, stamp_ns);
    if (kind_ != Kind::positions) return nearest.T_map_base;
    return position_between(previous, next, stamp_ns, max_bridge * max_difference_s_);
}

std::vector<PosePair> associate_by_stamp(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference, double max_difference_s) {
    return associate(estimate, reference, max_difference_s, ReferencePoses::Kind::poses);
}

std::vector<PosePair> associate_positions(const std::vector<StampedPose>& estimate,
                                          const std::vector<StampedPose>& reference,
                                          double max_difference_s) {
    return associate(estimate, reference, max_difference_s, ReferencePoses::Kind::positions);
}

std::vector<PosePair> associate_by_index(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference) {
    std::vector<PosePair> pairs;
    for (std::size_t i = 0; i < std::min(estimate.size(), reference.size()); ++i)
        pairs.push_back({estimate[i].stamp_ns, i, estimate[i].T_map_base, reference[i].T_map_base});
    return pairs;
}

}  // namespace loopline
