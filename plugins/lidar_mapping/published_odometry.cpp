#include "lidar_mapping/published_odometry.h"

#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cmath>

#include "api/observation_class.h"

namespace loopline::lidar_mapping {

bool PublishedOdometry::take(const mrpt::obs::CObservation& observation) {
    if (!wanted() || observation.sensorLabel != settings_.label) return false;
    const auto stamp_ns = stamp_from_mrpt(observation.timestamp);
    if (!stamp_ns || (!poses_.empty() && *stamp_ns <= poses_.back().stamp_ns)) return false;
    Sample sample;
    sample.stamp_ns = *stamp_ns;
    if (const auto* pose = as<mrpt::obs::CObservationRobotPose>(&observation)) {
        sample.known = pose_of(*pose);
        planar_ = false;
    } else if (const auto* wheels = as<mrpt::obs::CObservationOdometry>(&observation)) {
        const auto& p = wheels->odometry;
        sample.known.T_map_base = Pose3(Pose2{p.x(), p.y(), p.phi()});
        planar_ = true;
    } else {
        return false;
    }
    const auto& [T_odom_base, covariance] = sample.known;
    const bool finite = T_odom_base.translation_m.allFinite() && T_odom_base.rotation.coeffs().allFinite() &&
                        covariance.allFinite();
    if (!finite) return false;
    poses_.push_back(sample);
    ++taken_;
    return true;
}

std::size_t PublishedOdometry::before(StampNs stamp_ns) const {
    std::size_t first = poses_.size() - 2;
    while (first > 0 && poses_[first].stamp_ns > stamp_ns) --first;
    return first;
}

ScrewSegment PublishedOdometry::segment(std::size_t first) const {
    const Sample &a = poses_[first], &b = poses_[first + 1];
    return {a.stamp_ns, a.known.T_map_base, b.stamp_ns, b.known.T_map_base};
}

std::optional<GivenMotion> PublishedOdometry::motion(StampNs from_ns, StampNs to_ns) const {
    if (poses_.size() < 2) return std::nullopt;
    const std::size_t from = before(from_ns), to = before(to_ns);
    GivenMotion given;
    given.planar = planar_;
    given.sigma_scale = settings_.sigma_scale;
    given.T_last_now = segment(from).at(from_ns).inverse() * segment(to).at(to_ns);
    const Sample &a = poses_[to], &b = poses_[to + 1];
    const double over_s = seconds_between(a.stamp_ns, b.stamp_ns);
    given.velocity = log_se3(a.known.T_map_base.inverse() * b.known.T_map_base) * (1 / over_s);
    given.velocity_over_s = over_s;
    const Sample &c = poses_[from], &d = poses_[from + 1];
    given.velocity_before = log_se3(c.known.T_map_base.inverse() * d.known.T_map_base) *
                            (1 / seconds_between(c.stamp_ns, d.stamp_ns));
    given.velocity_covariance = added_covariance(a.known, b.known) / (over_s * over_s);
    const double share = seconds_between(from_ns, to_ns) / seconds_between(poses_[from].stamp_ns, b.stamp_ns);
    given.covariance = std::max(share, 0.0) * added_covariance(poses_[from].known, b.known);
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << Eigen::Vector3d::Constant(settings_.sigma_m), Eigen::Vector3d::Constant(settings_.sigma_rad);
    given.covariance.diagonal() += sigma.cwiseAbs2();
    given.velocity_covariance.diagonal() += (sigma / over_s).cwiseAbs2();
    return given;
}

void PublishedOdometry::forget_before(StampNs stamp_ns) {
    while (poses_.size() > 2 && poses_[1].stamp_ns < stamp_ns) poses_.pop_front();
}

}  // namespace loopline::lidar_mapping
