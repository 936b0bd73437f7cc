/// From the end of a loop back to its beginning (rows B7 to B9 of the method): the same scans in reverse
/// order, each matched with the old map and with those that came after it, from the pose that closing the
/// loop gave.
#pragma once

#include <vector>

#include "grid_slam/forward_match.h"
#include "grid_slam/map_frames.h"

namespace loopline::grid_slam {

/// A loop: from frame `first` of the old map to frame `last`, whose pose the old map gives.
struct Loop {
    std::uint32_t first = 0, last = 0;
    Pose2 T_map_last;                                      ///< of `last`, by the old map
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of it, given `first`; map axes
};

/// Poses and covariances of the frames first .. last; the covariances given `first`, map axes.
struct PassResult {
    std::vector<Pose2> poses;
    std::vector<Eigen::Matrix3d> covariances;
};

/// Motion between two neighbouring frames by navigation, backwards: navigation that can't go back (wheels)
/// has the inverse of its way forward.
class ReverseNavigation {
 public:
    virtual ~ReverseNavigation() = default;
    /// Starts at frame `last` of the loop, at a pose with its covariance (map axes).
    virtual void start(std::uint32_t frame, const Pose2& T_map_base, const Eigen::Matrix3d& covariance) = 0;
    /// Where the vehicle was at frame `to`, the one before the frame it is at.
    virtual Motion motion_back(std::uint32_t to) = 0;
    /// What the scan there said.
    virtual void update(const ForwardMatch& match) = 0;
};

/// `old_map`: frames that make the old map; those of the loop are not among them.
PassResult reverse_pass(const MapFrames& map, const std::vector<std::uint32_t>& old_map, const Loop& loop,
                        ReverseNavigation& navigation, const ForwardSettings& settings, double cell_m);

}  // namespace loopline::grid_slam
