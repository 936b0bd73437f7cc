#include "odometry/differential_drive.h"

#include <cmath>

namespace loopline {

Twist2 motion_from_ticks(const DifferentialDrive& drive, const WheelTicks& before, const WheelTicks& after) {
    const double left_m = static_cast<double>(after.left - before.left) * drive.metres_per_tick_left_m;
    const double right_m = static_cast<double>(after.right - before.right) * drive.metres_per_tick_right_m;
    return {(right_m + left_m) / 2, 0, (right_m - left_m) / drive.track_width_m};
}

WheelTicks TickUnwrapper::operator()(std::int32_t left, std::int32_t right) {
    const auto unwrapped = [](std::int64_t last, std::int32_t now) {
        const auto step = static_cast<std::uint32_t>(now) - static_cast<std::uint32_t>(last);  // modulo 2^32
        return last + static_cast<std::int32_t>(step);
    };
    last_ = last_ ? WheelTicks{unwrapped(last_->left, left), unwrapped(last_->right, right)}
                  : WheelTicks{left, right};
    return *last_;
}

Eigen::Matrix3d propagate_covariance(const Eigen::Matrix3d& covariance, const Pose2& T_map_a,
                                     const Pose2& T_map_b, const OdometryNoise& noise) {
    const Eigen::Vector2d step_m = T_map_b.translation() - T_map_a.translation();
    const double turn_rad = wrap_to_pi(T_map_b.phi_rad - T_map_a.phi_rad);
    const double way_m = step_m.norm();

    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    F(0, 2) = -step_m.y();
    F(1, 2) = step_m.x();

    const double mean_heading_rad = T_map_a.phi_rad + turn_rad / 2;
    const double c = std::cos(mean_heading_rad), s = std::sin(mean_heading_rad);
    Eigen::Matrix3d G = Eigen::Matrix3d::Identity();
    G.topLeftCorner<2, 2>() << c, -s, s, c;

    const Eigen::Vector3d variances(
        noise.along_m * noise.along_m * way_m, noise.across_m * noise.across_m * way_m,
        noise.heading_rad * noise.heading_rad * way_m +
            noise.heading_per_turn_rad * noise.heading_per_turn_rad * std::abs(turn_rad) / (2 * M_PI));
    return F * covariance * F.transpose() + G * variances.asDiagonal() * G.transpose();
}

}  // namespace loopline
