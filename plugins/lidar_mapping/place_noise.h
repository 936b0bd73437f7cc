/// What is not known of a return's place in the map: it would else look like a part of a surface's shape.
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "api/pose3.h"

namespace loopline::lidar_mapping {

/// Of a sweep against those just before it. What a vehicle that nothing holds has gone astray, it has
/// together with them, and the surfaces that it sees now are sound.
inline Matrix6d against_neighbours(const Matrix6d& pose_covariance) {
    constexpr double most_m = 0.2;
    const double variance_m2 = pose_covariance.topLeftCorner<3, 3>().trace();
    return std::min(1.0, most_m * most_m / variance_m2) * pose_covariance;
}

/// Where in the map a return lies is uncertain by its range and by the pose.
class PlaceNoise {
 public:
    PlaceNoise(const Matrix6d& pose_covariance, double sigma_range_m)
        : range_m2_(static_cast<float>(sigma_range_m * sigma_range_m)),
          shift_(pose_covariance.topLeftCorner<3, 3>().cast<float>()),
          turn_(pose_covariance.bottomRightCorner<3, 3>().cast<float>()),
          both_(pose_covariance.topRightCorner<3, 3>().cast<float>()) {}
    /// At `arm_m` from the vehicle, along map axes.
    Eigen::Matrix3f covariance_m2(const Eigen::Vector3f& arm_m, const Eigen::Vector3f& beam_map) const {
        Eigen::Matrix3f by_turn;  // of the place, -[arm]x
        by_turn << 0, arm_m.z(), -arm_m.y(), -arm_m.z(), 0, arm_m.x(), arm_m.y(), -arm_m.x(), 0;
        const Eigen::Matrix3f cross = both_ * by_turn.transpose();
        return range_m2_ * beam_map * beam_map.transpose() + shift_ + cross + cross.transpose() +
               by_turn * turn_ * by_turn.transpose();
    }

 private:
    float range_m2_;
    Eigen::Matrix3f shift_, turn_, both_;
};

}  // namespace loopline::lidar_mapping
