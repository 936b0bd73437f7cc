/// The latest part of a path that is still being estimated: where the vehicle was at a time.
#pragma once

#include <deque>
#include <optional>

#include "api/pose3_motion.h"

namespace loopline::cloud_map {

struct StampedPose3 {
    StampNs stamp_ns = 0;
    Pose3 T_map_base;
};

class PoseWindow {
 public:
    /// Neighbours farther apart than `max_gap_s` have no motion between them that anyone knows.
    explicit PoseWindow(double max_gap_s = 0.5) : max_gap_s_(max_gap_s) {}

    /// Stamps increase; a pose that does not come after the last one begins the window anew.
    void add(const StampedPose3& pose);
    bool empty() const { return poses_.empty(); }
    StampNs last_ns() const { return poses_.back().stamp_ns; }
    /// Keeps one pose before `stamp_ns`, and all after it.
    void forget_before(StampNs stamp_ns);

    /// At constant twist between the two neighbours; before the first and after the last pose, and on the
    /// near side of a gap, the motion next to it goes on, by no more than `max_gap_s`. None farther from any
    /// pose.
    std::optional<Pose3> at(StampNs stamp_ns) const;

 private:
    template <class Archive>
    friend void fields(Archive&, PoseWindow&);
    bool joined(std::size_t first) const;

    double max_gap_s_;
    std::deque<StampedPose3> poses_;
};

}  // namespace loopline::cloud_map
