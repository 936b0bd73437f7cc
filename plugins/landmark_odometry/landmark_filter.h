/// The vehicle and the landmarks about it as one Gaussian: SLAM by an extended Kalman filter, after Smith,
/// Self and Cheeseman 1990 and Dissanayake et al. 2001, in a frame that moves on with the vehicle, as in
/// Castellanos et al. 2007: angles stay small, and with them the errors of linearising.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "api/pose2.h"
#include "api/twist2.h"

namespace loopline::landmark_odometry {

/// A landmark as it was seen, in the vehicle's frame.
struct Sighting {
    Eigen::Vector2d p_base_m = Eigen::Vector2d::Zero();
    Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Identity();
};

/// What dead reckoning errs by: standard deviations after 1 m of way, or one full turn; variances grow in
/// proportion.
struct MotionNoise {
    double along_m = 0.05, across_m = 0.05;
    double heading_rad = 0.5 * M_PI / 180;
    double heading_per_turn_rad = 30 * M_PI / 180;
};

/// Where a landmark should be seen, and how far off a sighting of it is.
struct Innovation {
    Eigen::Vector2d off_m;
    Eigen::Matrix<double, 2, 3> by_pose;  ///< derivative of the place in the vehicle's frame
    Eigen::Matrix2d by_landmark;
    Eigen::Matrix2d covariance_m2;  ///< of off_m

    /// Chi-square of two.
    double square() const;
};

class LandmarkFilter {
 public:
    std::size_t landmarks() const { return static_cast<std::size_t>((state_.size() - 3) / 2); }
    /// In the filter's frame, `local`.
    Pose2 T_local_base() const { return {state_[0], state_[1], state_[2]}; }
    Eigen::Vector2d p_local_m(std::size_t landmark) const { return state_.segment<2>(at(landmark)); }
    /// Of (x, y, phi), along the axes of `local`, about the vehicle.
    Eigen::Matrix3d pose_covariance() const { return covariance_.topLeftCorner<3, 3>(); }
    Eigen::Matrix2d landmark_covariance_m2(std::size_t landmark) const {
        return covariance_.block<2, 2>(at(landmark), at(landmark));
    }

    void move(const Twist2& told, const MotionNoise& noise);
    Innovation innovation(std::size_t landmark, const Sighting& sighting) const;
    void update(std::size_t landmark, const Innovation& innovation);
    /// It becomes the last one.
    void add(const Sighting& sighting);
    void remove(std::size_t landmark);
    /// From now on `local` is where the vehicle is; the pose is known there, and what it erred by against
    /// the landmarks is theirs.
    void begin_anew();

 private:
    template <class Archive>
    friend void fields(Archive& archive, LandmarkFilter& filter) {
        archive(filter.state_, filter.covariance_);
    }
    static Eigen::Index at(std::size_t landmark) { return 3 + 2 * static_cast<Eigen::Index>(landmark); }

    Eigen::VectorXd state_ = Eigen::VectorXd::Zero(3);  ///< x, y, phi, then x, y of each landmark
    Eigen::MatrixXd covariance_ = Eigen::MatrixXd::Zero(3, 3);
};

}  // namespace loopline::landmark_odometry
