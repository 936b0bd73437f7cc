#include "api/pose_observation.h"

#include <cmath>

#include "api/dense_algebra.h"
#include "api/mrpt_pose.h"

namespace loopline {
namespace {

/// d(x y z yaw pitch roll) -> (shift, turn): the axes of yaw, pitch and roll, seen from the map.
Matrix6d from_angles(double yaw_rad, double pitch_rad) {
    const double cy = std::cos(yaw_rad), sy = std::sin(yaw_rad), cp = std::cos(pitch_rad),
                 sp = std::sin(pitch_rad);
    Matrix6d E = Matrix6d::Identity();
    E.bottomRightCorner<3, 3>() << 0, -sy, cy * cp,  //
        0, cy, sy * cp,                              //
        1, 0, -sp;
    return E;
}

}  // namespace

mrpt::obs::CObservationRobotPose::Ptr pose_observation(const std::string& label,
                                                       const mrpt::Clock::time_point& timestamp,
                                                       const Pose3& T_map_base, const Matrix6d& covariance) {
    auto observation = mrpt::obs::CObservationRobotPose::Create();
    observation->sensorLabel = label;
    observation->timestamp = timestamp;
    const auto& q = T_map_base.rotation;
    const auto& t_m = T_map_base.translation_m;
    const mrpt::poses::CPose3D mean(mrpt::math::CQuaternionDouble(q.w(), q.x(), q.y(), q.z()), t_m.x(),
                                    t_m.y(), t_m.z());
    observation->pose.mean = mean;
    const Matrix6d to_angles = inverse_of(from_angles(mean.yaw(), mean.pitch()));
    observation->pose.cov.asEigen() = propagated(to_angles, covariance);
    return observation;
}

PoseWithCovariance pose_of(const mrpt::obs::CObservationRobotPose& observation) {
    const auto& mean = observation.pose.mean;
    const Matrix6d E = from_angles(mean.yaw(), mean.pitch());
    return {pose3_from_mrpt(mean), propagated(E, observation.pose.cov.asEigen())};
}

Matrix6d added_covariance(const PoseWithCovariance& from, const PoseWithCovariance& to) {
    const Eigen::Vector3d way_m = to.T_map_base.translation_m - from.T_map_base.translation_m;
    Matrix6d F = Matrix6d::Identity(), R = Matrix6d::Zero();  // an error of the attitude turns the way
    F.topRightCorner<3, 3>() << 0, way_m.z(), -way_m.y(), -way_m.z(), 0, way_m.x(), way_m.y(), -way_m.x(), 0;
    R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() =
        from.T_map_base.rotation.conjugate().toRotationMatrix();
    const Matrix6d added = propagated(R, to.covariance - propagated(F, from.covariance));
    const Spectrum spectrum = spectrum_of((added + added.transpose()) / 2);
    return spectrum.vectors * spectrum.values.cwiseMax(0).asDiagonal() * spectrum.vectors.transpose();
}

}  // namespace loopline
