#include "simulation/driver.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace loopline::simulation {

Driver::Driver(Waypoints waypoints, const DriverSettings& settings, const VehicleSettings& vehicle)
    : waypoints_(std::move(waypoints)), settings_(settings) {
    assert(waypoints_.size() >= 2);
    const double forward_mps = (vehicle.turn_outer_mps + vehicle.turn_inner_mps) / 2;
    const double turn_radps = (vehicle.turn_outer_mps - vehicle.turn_inner_mps) / vehicle.track_width_m;
    turn_radius_m_ = forward_mps / turn_radps;
    overrun_rad_ = turn_radps * vehicle.wheel_lag_s;
}

double Driver::leg_heading_rad(std::size_t leg) const {
    const Eigen::Vector2d way_m = waypoints_[leg + 1] - waypoints_[leg];
    return std::atan2(way_m.y(), way_m.x());
}

Pose2 Driver::start() const {
    return {waypoints_[0].x(), waypoints_[0].y(), leg_heading_rad(0)};
}

/// Goes on turning until the heading error is about to vanish.
Regime Driver::turn_until(double error_rad) {
    const double left_to_turn_rad = regime_ == Regime::left ? error_rad : -error_rad;
    // More than half a turn back is not behind: it is a turn about that has only begun.
    if (left_to_turn_rad <= overrun_rad_ && left_to_turn_rad > -M_PI / 2) regime_ = Regime::straight;
    return regime_;
}

Regime Driver::command(const Pose2& T_world_base) {
    const Eigen::Vector2d to_go_m = waypoints_[leg_ + 1] - T_world_base.translation();
    const double heading_rad = leg_heading_rad(leg_);
    const Eigen::Vector2d ahead(std::cos(heading_rad), std::sin(heading_rad));
    const double beside_m = -(ahead.x() * to_go_m.y() - ahead.y() * to_go_m.x());  // > 0: left of the leg
    const bool last_leg = leg_ + 2 == waypoints_.size();
    if (last_leg && to_go_m.dot(ahead) <= 0) arrived_ = true;

    if (!last_leg) {
        const double corner_rad = wrap_to_pi(leg_heading_rad(leg_ + 1) - heading_rad);
        // The tangent of an arc around the corner; a vehicle that has to turn back does so beyond its end.
        const double lead_m = turn_radius_m_ * std::tan(std::min(std::abs(corner_rad), M_PI / 2) / 2);
        if (to_go_m.dot(ahead) <= lead_m) {
            ++leg_;
            regime_ = std::abs(corner_rad) < overrun_rad_ ? Regime::straight
                      : corner_rad > 0                    ? Regime::left
                                                          : Regime::right;
            return regime_;
        }
    }
    const double approach_rad = std::clamp(-settings_.approach_rad_per_m * beside_m,
                                           -settings_.max_approach_rad, settings_.max_approach_rad);
    const double error_rad = wrap_to_pi(heading_rad + approach_rad - T_world_base.phi_rad);
    if (regime_ != Regime::straight) return turn_until(error_rad);
    if (std::abs(error_rad) > settings_.deadband_rad) regime_ = error_rad > 0 ? Regime::left : Regime::right;
    return regime_;
}

}  // namespace loopline::simulation
