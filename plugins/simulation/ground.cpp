#include "simulation/ground.h"

#include <cmath>

namespace loopline::simulation {

Pose3 on_floor(const Pose2& planar, const FloorAttitude& floor) {
    const Eigen::AngleAxisd yaw(planar.phi_rad, Eigen::Vector3d::UnitZ()),
        pitch(floor.pitch_rad, Eigen::Vector3d::UnitY()), roll(floor.roll_rad, Eigen::Vector3d::UnitX());
    return {{planar.x_m, planar.y_m, floor.z_m}, Eigen::Quaterniond(yaw * pitch * roll)};
}

FloorAttitude Ground::below(const Pose2& T_ground_base) const {
    const Eigen::Vector2d place_m = T_ground_base.translation();
    const Eigen::Vector2d rise = slope(place_m);
    const Eigen::Vector2d ahead(std::cos(T_ground_base.phi_rad), std::sin(T_ground_base.phi_rad));
    const double ahead_slope = rise.dot(ahead), left_slope = -ahead.y() * rise.x() + ahead.x() * rise.y();
    // The x axis rises by the slope ahead; the y axis, turned about it, by that to the left.
    const double pitch_rad = -std::atan(ahead_slope);
    return {height_m(place_m), pitch_rad, std::atan(left_slope * std::cos(pitch_rad))};
}

}  // namespace loopline::simulation
