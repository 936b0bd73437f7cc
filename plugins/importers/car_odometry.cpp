#include "importers/car_odometry.h"

namespace loopline {
namespace {

/// Where a constant velocity leads within `step_s`: the exponential of its twist.
Pose2 arc(const CarVelocity& velocity, double step_s) {
    const double angle_rad = velocity.turn_radps * step_s;
    const double forward_m = velocity.forward_mps * step_s, left_m = velocity.left_mps * step_s;
    // sin(x) / x and (1 - cos x) / x, by their series where they lose digits
    const bool small = std::abs(angle_rad) < 1e-4;
    const double along = small ? 1 - angle_rad * angle_rad / 6 : std::sin(angle_rad) / angle_rad;
    const double aside = small ? angle_rad / 2 : (1 - std::cos(angle_rad)) / angle_rad;
    return {along * forward_m - aside * left_m, aside * forward_m + along * left_m, angle_rad};
}

}  // namespace

CarVelocity velocity_by_steering(const SteeredCar& car, double wheel_mps, double steering_rad) {
    const double curvature = std::tan(steering_rad) / car.wheel_base_m;
    const double forward_mps = wheel_mps / (1 - curvature * car.encoder_left_m);
    return {forward_mps, 0, curvature * forward_mps};
}

CarVelocity velocity_by_wheels(double track_width_m, double left_mps, double right_mps) {
    return {(left_mps + right_mps) / 2, 0, (right_mps - left_mps) / track_width_m};
}

void CarPath::add(StampNs stamp_ns, const CarVelocity& velocity) {
    if (begun_ && stamp_ns > latest_ns_) {
        const CarVelocity mean{(latest_.forward_mps + velocity.forward_mps) / 2,
                               (latest_.left_mps + velocity.left_mps) / 2,
                               (latest_.turn_radps + velocity.turn_radps) / 2};
        T_odom_base_ = T_odom_base_ * arc(mean, seconds_between(latest_ns_, stamp_ns));
    }
    if (!begun_ || stamp_ns > latest_ns_) latest_ns_ = stamp_ns;
    latest_ = velocity;
    begun_ = true;
}

}  // namespace loopline
