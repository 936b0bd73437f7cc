#include "grid_slam/relative_uncertainty.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <queue>

namespace loopline::grid_slam {
namespace {

/// Of the position, along the axis where it is larger.
double larger_variance(double xx, double xy, double yy) {
    const double mean = (xx + yy) / 2, half = (xx - yy) / 2, spread = std::sqrt(half * half + xy * xy);
    return mean + spread;
}

}  // namespace

void Neighbourhood::add(const Constraint& constraint, const Pose2& T_map_from) {
    // What is not known at all gets a large variance, not an infinite one.
    const Eigen::Matrix3d information =
        constraint.information + Eigen::Vector3d(1e-2, 1e-2, 1e-1).asDiagonal().toDenseMatrix();
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    const double c = std::cos(T_map_from.phi_rad), s = std::sin(T_map_from.phi_rad);
    turn.topLeftCorner<2, 2>() << c, -s, s, c;
    const Eigen::Matrix3d covariance = turn * information.inverse() * turn.transpose();
    edges_[constraint.from].push_back({constraint.to, covariance});
    // Gone backward, the error of its heading turns its own way.
    const Eigen::Vector2d way_map_m = turn.topLeftCorner<2, 2>() * constraint.T_from_to.translation();
    const Eigen::Matrix3d back = carried_by(-way_map_m);
    edges_[constraint.to].push_back({constraint.from, back * covariance * back.transpose()});
}

void relative_uncertainty(const Neighbourhood& graph, const std::vector<Pose2>& poses, std::uint32_t origin,
                          double limit_m2, RelativeUncertainty& result) {
    const std::size_t n = graph.size();
    result.variance_m2.assign(n, RelativeUncertainty::unknown);
    result.covariance.resize(n);
    result.reached.clear();
    thread_local std::vector<bool> settled;
    settled.assign(n, false);
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    result.variance_m2[origin] = 0;
    result.covariance[origin].setZero();
    queue.emplace(0, origin);
    while (!queue.empty()) {
        const auto [variance, frame] = queue.top();
        queue.pop();
        if (settled[frame]) continue;
        settled[frame] = true;
        result.reached.push_back(frame);
        for (const auto& edge : graph.of(frame)) {
            if (settled[edge.other]) continue;
            // The heading's error turns the way to the next frame.
            const Carried there(result.covariance[frame],
                                poses[edge.other].translation() - poses[frame].translation());
            const double next =
                larger_variance(there.xx + edge.covariance(0, 0), there.xy + edge.covariance(0, 1),
                                there.yy + edge.covariance(1, 1));
            if (next >= limit_m2 || next >= result.variance_m2[edge.other]) continue;
            result.variance_m2[edge.other] = next;
            result.covariance[edge.other] = there.matrix() + edge.covariance;
            queue.emplace(next, edge.other);
        }
    }
}

}  // namespace loopline::grid_slam
