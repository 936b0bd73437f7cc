/// Poses of a trajectory at any time, one after the other: for what was measured between two scans.
#pragma once

#include <cstdint>
#include <optional>

#include "api/pose3_motion.h"
#include "api/trajectory.h"

namespace loopline {

/// Interpolates at constant twist between neighbours of the trajectory, and keeps the pair that it used last:
/// the beams of a sweep ask for hundreds of poses on one.
class PathSampler {
 public:
    /// `trajectory` outlives the sampler and does not change meanwhile. Neighbours farther apart in time than
    /// `max_gap_s` enclose a time that has no pose.
    PathSampler(const Trajectory& trajectory, double max_gap_s);

    /// The pose at a time; `hint_sequence` says about where in the log. `nullopt` before the first pose,
    /// after the last, in a gap, and where a neighbour is not finite.
    std::optional<Pose3> at(StampNs stamp_ns, std::uint64_t hint_sequence);

 private:
    const Trajectory* trajectory_;
    double max_gap_s_;
    StampNs first_ns_ = 0, last_ns_ = -1;  ///< of all stamps, whatever their order
    std::uint64_t hint_ = 0;               ///< that the pair in use was found by
    StampNs low_ns_ = 0, high_ns_ = -1;    ///< of the pair in use; none while high < low
    bool usable_ = false;                  ///< the pair in use: finite, and no gap
    ScrewSegment segment_;
};

}  // namespace loopline
