#include "lidar_mapping/published_odometry.h"

#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "api/observation_class.h"
#include "api/pose_observation.h"
#include "inertial/rotation_vector.h"

namespace loopline::lidar_mapping {

bool PublishedOdometry::take(const mrpt::obs::CObservation& observation) {
    if (!wanted() || observation.sensorLabel != settings_.label) return false;
    const auto stamp_ns = stamp_from_mrpt(observation.timestamp);
    if (!stamp_ns || (!poses_.empty() && *stamp_ns <= poses_.back().stamp_ns)) return false;
    Sample sample;
    sample.stamp_ns = *stamp_ns;
    if (const auto* pose = as<mrpt::obs::CObservationRobotPose>(&observation)) {
        const PoseWithCovariance read = pose_of(*pose);
        sample.T_odom_base = read.T_map_base;
        sample.covariance = read.covariance;
        planar_ = false;
    } else if (const auto* wheels = as<mrpt::obs::CObservationOdometry>(&observation)) {
        const auto& p = wheels->odometry;
        sample.T_odom_base = Pose3(Pose2{p.x(), p.y(), p.phi()});
        planar_ = true;
    } else {
        return false;
    }
    const bool finite = sample.T_odom_base.translation_m.allFinite() &&
                        sample.T_odom_base.rotation.coeffs().allFinite() && sample.covariance.allFinite();
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
    return {a.stamp_ns, a.T_odom_base, b.stamp_ns, b.T_odom_base};
}

/// What covariance the way between two poses adds, along the vehicle's axes at the first: odometry's errors
/// add up.
Matrix6d PublishedOdometry::growth(const Sample& from, const Sample& to) const {
    Matrix6d F = Matrix6d::Identity(), R = Matrix6d::Zero();
    F.topRightCorner<3, 3>() =
        -inertial::cross_matrix(to.T_odom_base.translation_m - from.T_odom_base.translation_m);
    R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() =
        from.T_odom_base.rotation.conjugate().toRotationMatrix();
    const Matrix6d added = R * (to.covariance - F * from.covariance * F.transpose()) * R.transpose();
    Eigen::SelfAdjointEigenSolver<Matrix6d> eigen((added + added.transpose()) / 2);
    const Eigen::Matrix<double, 6, 1> positive = eigen.eigenvalues().cwiseMax(0);
    return eigen.eigenvectors() * positive.asDiagonal() * eigen.eigenvectors().transpose();
}

std::optional<GivenMotion> PublishedOdometry::motion(StampNs from_ns, StampNs to_ns) const {
    if (poses_.size() < 2) return std::nullopt;
    const std::size_t from = before(from_ns), to = before(to_ns);
    GivenMotion given;
    given.planar = planar_;
    given.T_last_now = segment(from).at(from_ns).inverse() * segment(to).at(to_ns);
    const Sample &a = poses_[to], &b = poses_[to + 1];
    const double over_s = seconds_between(a.stamp_ns, b.stamp_ns);
    given.velocity = log_se3(a.T_odom_base.inverse() * b.T_odom_base) * (1 / over_s);
    given.velocity_over_s = over_s;
    given.velocity_covariance = growth(a, b) / (over_s * over_s);
    const double share = seconds_between(from_ns, to_ns) / seconds_between(poses_[from].stamp_ns, b.stamp_ns);
    given.covariance = std::max(share, 0.0) * growth(poses_[from], b);
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
