#include "grid_slam/fusion_of_passes.h"

#include <Eigen/LU>
#include <cassert>

namespace loopline::grid_slam {
namespace {

Eigen::Vector3d difference(const Pose2& from, const Pose2& to) {
    return {to.x_m - from.x_m, to.y_m - from.y_m, wrap_to_pi(to.phi_rad - from.phi_rad)};
}

Pose2 moved(const Pose2& pose, const Eigen::Vector3d& by) {
    return {pose.x_m + by.x(), pose.y_m + by.y(), wrap_to_pi(pose.phi_rad + by.z())};
}

/// x = x_f + P_f (P_f + P_r)^-1 (x_r - x_f), P = P_f - P_f (P_f + P_r)^-1 P_f: where one pass knows all, as
/// each does at its own end, it decides, without an inverse of zero.
void fuse_by_covariance(const PassResult& forward, const PassResult& reverse, std::size_t i,
                        PassResult& fused) {
    const Eigen::Matrix3d& P_f = forward.covariances[i];
    const Eigen::Matrix3d sum = P_f + reverse.covariances[i] + 1e-12 * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d gain = P_f * sum.inverse();
    fused.poses.push_back(moved(forward.poses[i], gain * difference(forward.poses[i], reverse.poses[i])));
    const Eigen::Matrix3d P = P_f - gain * P_f;
    fused.covariances.push_back(0.5 * (P + P.transpose()));
}

}  // namespace

PassResult fuse(const PassResult& forward, const PassResult& reverse, Weights weights) {
    assert(forward.poses.size() == reverse.poses.size());
    PassResult fused;
    const std::size_t n = forward.poses.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (weights != Weights::linear) {
            fuse_by_covariance(forward, reverse, i, fused);
            continue;
        }
        const double w = n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 1;
        fused.poses.push_back(moved(forward.poses[i], w * difference(forward.poses[i], reverse.poses[i])));
        fused.covariances.push_back((1 - w) * (1 - w) * forward.covariances[i] +
                                    w * w * reverse.covariances[i]);
    }
    return fused;
}

}  // namespace loopline::grid_slam
