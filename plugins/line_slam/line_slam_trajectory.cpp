/// Where the vehicle was at every scan, also at those between two steps of the filter.
#include <Eigen/Geometry>

#include "api/twist2.h"
#include "line_slam/line_slam_module.h"

namespace loopline {

using namespace line_slam;

/// As it was known at each time: by the filter at its steps, by the wheels since the last step between them.
void LineSlam::lay_out_trajectory() {
    PreparedPose2 T_map_step;
    Eigen::Matrix3d step_covariance = Eigen::Matrix3d::Zero();
    std::size_t steps = 0;
    for (const ScanPlace& place : places_) {
        if (place.is_step) {
            T_map_step = PreparedPose2(steps_[steps].T_map_base);
            step_covariance = steps_[steps++].covariance;
            trajectory_.append(place.sequence, place.stamp_ns, Pose3(T_map_step.pose()),
                               PoseCovariance::planar(step_covariance));
            continue;
        }
        // The step's own error turns the way since then about it.
        const Pose2 T_map_base = T_map_step * place.T_step_base;
        Eigen::Matrix3d carried = Eigen::Matrix3d::Identity();
        carried.topRightCorner<2, 1>() =
            turned_left(T_map_base.translation() - T_map_step.pose().translation());
        trajectory_.append(place.sequence, place.stamp_ns, Pose3(T_map_base),
                           PoseCovariance::planar(carried * step_covariance * carried.transpose() +
                                                  noise_since_step(T_map_step.pose(), place)));
    }
}

/// What the wheels' noise adds to (x, y, phi) from a step to a scan after it.
Eigen::Matrix3d LineSlam::noise_since_step(const Pose2& T_map_step, const ScanPlace& place) const {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_map_step.phi_rad).toRotationMatrix();
    return turn * interval_->noise_on(place.T_step_base, place.regime) * turn.transpose();
}

/// Steps take the smoothed poses, scans between them what the wheels say, bent so that it leads from one step
/// to the next.
void LineSlam::revise_trajectory(const SmoothedPath& smoothed) {
    std::size_t step = 0, last = 0;
    for (std::size_t k = 0; k < places_.size(); ++k) {
        if (!places_[k].is_step) continue;
        trajectory_.revise(k, Pose3(smoothed.poses[step]),
                           PoseCovariance::planar(smoothed.covariances[step]));
        if (step > 0) revise_between(last, k);
        last = k;
        ++step;
    }
    trajectory_.finish_revision();
}

void LineSlam::revise_between(std::size_t from, std::size_t to) {
    const auto entries = trajectory_.entries();
    const PreparedPose2 T_map_from(entries[from].T_map_base.planar());
    const Pose2 T_map_to = entries[to].T_map_base.planar();
    const Twist2 bend = log_se2((T_map_from * places_[to].T_step_base).inverse() * T_map_to);
    const Eigen::Matrix3d noise = noise_since_step(T_map_from.pose(), places_[to]),
                          covariance_from = entries[from].covariance.planar(),
                          covariance_to = entries[to].covariance.planar();
    for (std::size_t k = from + 1; k < to; ++k) {
        const double u = static_cast<double>(k - from) / static_cast<double>(to - from);
        // Between two known poses the wheels' noise is that of a bridge.
        trajectory_.revise(
            k, Pose3(T_map_from * places_[k].T_step_base * exp_se2(bend * u)),
            PoseCovariance::planar((1 - u) * covariance_from + u * covariance_to + u * (1 - u) * noise));
    }
}

}  // namespace loopline
