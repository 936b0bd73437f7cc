/// Spatial motion at constant twist: exponential and logarithm of SE(3), and interpolation along the screw
/// between two poses. Sola, Deray, Atchuthan 2018, "A micro Lie theory for state estimation in robotics", eq.
/// (170)-(174).
#pragma once

#include <Eigen/Core>

#include "api/pose3.h"
#include "api/stamp.h"

namespace loopline {

/// A constant spatial velocity times its duration, in the moving frame. Divided by a time it is a velocity.
struct Twist3 {
    Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< axis times angle

    Twist3 operator*(double factor) const { return {factor * shift_m, factor * turn_rad}; }
    Twist3 operator+(const Twist3& o) const { return {shift_m + o.shift_m, turn_rad + o.turn_rad}; }
    Twist3 operator-(const Twist3& o) const { return {shift_m - o.shift_m, turn_rad - o.turn_rad}; }
};

/// Where `twist` ends: T_start_end. A turn of any size is followed along its screw.
Pose3 exp_se3(const Twist3& twist);

/// The shortest constant twist that leads to `T_start_end`: its turn is at most pi.
Twist3 log_se3(const Pose3& T_start_end);

/// The pose at the part `u` of the constant-twist way from `T_map_a` (u = 0) to `T_map_b` (u = 1); other u
/// extrapolate.
Pose3 interpolate_se3(const Pose3& T_map_a, const Pose3& T_map_b, double u);

/// The constant-twist way between two timed poses, its logarithm taken once: a sweep asks for hundreds of
/// poses on it.
class ScrewSegment {
 public:
    ScrewSegment() = default;
    /// The two times may be equal (the pose is then `T_map_a` at any time) and in either order.
    ScrewSegment(StampNs a_ns, const Pose3& T_map_a, StampNs b_ns, const Pose3& T_map_b);

    /// Before the first and after the last time the motion goes on.
    Pose3 at(StampNs stamp_ns) const {
        return T_map_a_ * exp_se3(velocity_ * seconds_between(a_ns_, stamp_ns));
    }

 private:
    StampNs a_ns_ = 0;
    Pose3 T_map_a_;
    Twist3 velocity_;  ///< a second
};

}  // namespace loopline
