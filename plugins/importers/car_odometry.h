/// Motion of a car by its wheels: the middle of the axle that is not steered, which rolls without slipping to
/// the side.
#pragma once

#include "api/pose2.h"
#include "api/stamp.h"

namespace loopline {

/// Of the middle of that axle: m/s ahead and to the left, rad/s counter-clockwise.
struct CarVelocity {
    double forward_mps = 0, left_mps = 0, turn_radps = 0;
};

/// A car that steers its front wheels, with one encoder.
struct SteeredCar {
    double wheel_base_m = 2.7;  ///< L, from axle to axle
    double encoder_left_m =
        0;  ///< H: of the wheel whose speed is measured, left of the middle of the rear axle
};

/// By the speed of that wheel and the steering angle a of the front wheels, to the left: with w = v tan(a) /
/// L the wheel runs at v - w H, so v = v_wheel / (1 - tan(a) H / L) (Guivant and Nebot 2001). The angle is
/// within a right one, and less than where the car would turn about the wheel.
CarVelocity velocity_by_steering(const SteeredCar& car, double wheel_mps, double steering_rad);

/// By the speeds of both wheels of the axle: their mean, and their difference over the track width.
CarVelocity velocity_by_wheels(double track_width_m, double left_mps, double right_mps);

/// Adds up the arcs that velocities lead along, the mean of two neighbours between them.
class CarPath {
 public:
    /// Times that do not go on leave the pose where it is.
    void add(StampNs stamp_ns, const CarVelocity& velocity);
    /// From the first velocity on.
    const Pose2& T_odom_base() const { return T_odom_base_; }

 private:
    Pose2 T_odom_base_;
    StampNs latest_ns_ = 0;
    CarVelocity latest_;
    bool begun_ = false;
};

}  // namespace loopline
