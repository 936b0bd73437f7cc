#include "line_slam/line_observation.h"

#include <cmath>

namespace loopline::line_slam {

PlanarLine predicted_line(const Pose2& T_map_base, const PlanarLine& line_map) {
    return {line_map.rho_m - line_map.normal().dot(T_map_base.translation()),
            wrap_to_pi(line_map.alpha_rad - T_map_base.phi_rad)};
}

Eigen::Vector2d innovation(const PlanarLine& observed_base, const PlanarLine& predicted_base) {
    const double turn_rad = wrap_to_pi(observed_base.alpha_rad - predicted_base.alpha_rad);
    return {observed_base.rho_m * std::cos(turn_rad) - predicted_base.rho_m, turn_rad};
}

Eigen::Vector2d difference(const PlanarLine& a, const PlanarLine& b) {
    return {a.rho_m - b.rho_m, wrap_to_pi(a.alpha_rad - b.alpha_rad)};
}

ObservationJacobians observation_jacobians(const Pose2& T_map_base, const PlanarLine& line_map,
                                           const Eigen::Vector2d& first_normal) {
    const double along_m = line_map.along_m(T_map_base.translation());
    ObservationJacobians H;
    H.pose << -first_normal.x(), -first_normal.y(), along_m, 0, 0, -1;
    H.line << 1, -along_m, 0, 1;
    return H;
}

AugmentationJacobians augmentation_jacobians(const Pose2& T_map_base, const PlanarLine& line_map) {
    const Eigen::Vector2d n = line_map.normal();
    AugmentationJacobians G;
    G.pose << n.x(), n.y(), 0, 0, 0, 1;
    G.observation << 1, line_map.along_m(T_map_base.translation()), 0, 1;
    return G;
}

Pose2 corrected(const Pose2& T_map_base, const Eigen::Vector3d& error) {
    return Pose2{error.x(), error.y(), error.z()} * T_map_base;
}

Eigen::Matrix3d coordinates_from_error(const Pose2& T_map_base) {
    Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
    jacobian.topRightCorner<2, 1>() = turned_left(T_map_base.translation());
    return jacobian;
}

Eigen::Matrix3d adjoint(const Pose2& T) {
    const double c = std::cos(T.phi_rad), s = std::sin(T.phi_rad);
    Eigen::Matrix3d Ad;
    Ad << c, -s, T.y_m, s, c, -T.x_m, 0, 0, 1;
    return Ad;
}

}  // namespace loopline::line_slam
