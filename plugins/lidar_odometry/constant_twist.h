/// The motion between two sweeps at a constant twist, and where it puts the points of both: seen from the
/// vehicle in the middle of the sweep before. (Yu et al. 2022, section 1.2: both sweeps are projected to one
/// time, and the motion between is uniform.)
#pragma once

#include <Eigen/Core>
#include <array>

#include "api/pose3_motion.h"

namespace loopline::lidar_odometry {

using Row6d = Eigen::Matrix<double, 1, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The left Jacobian of SE(3) at (shift, turn): exp(x + dx) = exp(J dx) exp(x). Sola, Deray, Atchuthan 2018,
/// eq. (179), as its power series, whose terms fall off with the angle.
Matrix6d left_jacobian_se3(const Twist3& twist);

class ConstantTwist {
 public:
    /// From the middle of the sweep before to the middle of this one, `duration_s` later (above 0).
    ConstantTwist(const Pose3& T_before_now, double duration_s);

    /// The part of the motion that is over `time_s` after the middle of this sweep: 1 in the middle.
    double part(double time_s) const { return 1 + time_s / duration_s_; }
    /// Where the vehicle is then: T_before_vehicle.
    Pose3 at(double time_s) const { return exp_se3(twist_ * part(time_s)); }
    /// d(n . p)/dx of a point p of this sweep, seen from before; x: (shift, turn) put in front of
    /// T_before_now, whose motion stays at a constant twist.
    Row6d derivative(const Eigen::Vector3d& n, const Eigen::Vector3d& p_before_m, double time_s) const;

 private:
    static constexpr std::size_t terms = 5;
    Twist3 twist_;
    double duration_s_;
    /// Of u J(u twist) J(twist)^-1 = sum of u^(k+1) series_[k]: what a change of T_before_now does to the
    /// pose at the part u.
    std::array<Matrix6d, terms> series_;
};

}  // namespace loopline::lidar_odometry
