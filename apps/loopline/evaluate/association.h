/// Which pose of the reference belongs to which pose of the estimate.
#pragma once

#include <cstddef>
#include <vector>

#include "output/tum.h"

namespace loopline {

struct PosePair {
    StampNs stamp_ns = 0;            ///< of the estimate
    std::size_t estimate_index = 0;  ///< in the order of its file
    Pose3 T_map_base_estimate;
    Pose3 T_ref_base_reference;
};

/// The poses of a point of the vehicle at `point_m` in base, ahead and left.
std::vector<StampedPose> way_of_point(std::vector<StampedPose> poses, const Eigen::Vector2d& point_m);

/// Every pose of the estimate, in its own order, with the reference pose whose stamp is nearest to its own;
/// left out if that is farther than `max_difference_s`. Either may have stamps that go backwards. Several
/// poses may share one reference pose.
std::vector<PosePair> associate_by_stamp(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference, double max_difference_s);

/// The same, for a reference of positions alone (of a tracker, say, with a clock of its own rate): each is
/// interpolated between the two reference poses around the estimate's stamp, where there are two and neither
/// is farther than ten times `max_difference_s`.
std::vector<PosePair> associate_positions(const std::vector<StampedPose>& estimate,
                                          const std::vector<StampedPose>& reference, double max_difference_s);

/// First with first, and so on, as long as both have poses.
std::vector<PosePair> associate_by_index(const std::vector<StampedPose>& estimate,
                                         const std::vector<StampedPose>& reference);

}  // namespace loopline
