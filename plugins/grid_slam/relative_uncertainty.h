/// How well the pose of one frame is known from another one, by the constraints between them.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "grid_slam/pose_graph.h"

namespace loopline::grid_slam {

/// Constraints by the frames that they join.
class Neighbourhood {
 public:
    struct Edge {
        std::uint32_t other;
        Eigen::Matrix3d covariance;  ///< of the other pose's (x, y, phi) given this one; map axes
    };
    void resize(std::size_t frames) { edges_.resize(frames); }
    /// With the covariance of T_from_to turned into the axes of the map.
    void add(const Constraint& constraint, const Pose2& T_map_from);
    const std::vector<Edge>& of(std::uint32_t frame) const { return edges_[frame]; }
    std::size_t size() const { return edges_.size(); }
    void clear() { edges_.clear(); }

 private:
    std::vector<std::vector<Edge>> edges_;
};

/// Of each frame given the pose of `origin`: along the one chain of constraints that leaves the least of it
/// (Dijkstra 1959), so more than what all constraints together would leave. Map axes, the lever arm included.
struct RelativeUncertainty {
    static constexpr double unknown = std::numeric_limits<double>::infinity();
    std::vector<double> variance_m2;  ///< of the position, the larger axis; `unknown` beyond the limit
    std::vector<Eigen::Matrix3d> covariance;  ///< of (x, y, phi)
    std::vector<std::uint32_t> reached;       ///< in the order of their variance
};
void relative_uncertainty(const Neighbourhood& graph, const std::vector<Pose2>& poses, std::uint32_t origin,
                          double limit_m2, RelativeUncertainty& result);

}  // namespace loopline::grid_slam
