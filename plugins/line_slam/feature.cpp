#include "line_slam/feature.h"

#include <cmath>

namespace loopline::line_slam {
namespace {

constexpr double nearest_foot_m = 0.05;  // nearer, the bearing is noise

double bearing(const Eigen::Vector2d& p) {
    return std::atan2(p.y(), p.x());
}

/// d(range, bearing) / d(point).
Eigen::Matrix2d polar_jacobian(const Eigen::Vector2d& p) {
    const double range = p.norm();
    Eigen::Matrix2d J;
    J << p.transpose() / range, turned_left(p).transpose() / (range * range);
    return J;
}

ObservationJacobians foot_point_jacobians(const Pose2& T_map_base, const PlanarLine& line_map) {
    const Eigen::Vector2d p = T_map_base.translation();
    const Eigen::Matrix2d to_polar = polar_jacobian(line_map.point_m(0) - p);
    ObservationJacobians H;
    H.pose.leftCols<2>() = -to_polar;
    H.pose.col(2) = -to_polar * turned_left(p) - Eigen::Vector2d(0, 1);
    H.line.col(0) = to_polar * line_map.normal();
    H.line.col(1) = to_polar * (line_map.rho_m * line_map.tangent());
    return H;
}

/// Eq. (11).
FeaturePrediction predict_foot_point(const Pose2& T_map_base, const PlanarLine& line_map,
                                     const LineObservation& observation, const Eigen::Matrix2d& covariance) {
    const Eigen::Vector2d predicted = T_map_base.inverse() * line_map.point_m(0);

    // "Measured": the perpendicular from where the predicted pose puts the origin.
    const Eigen::Vector2d origin = T_map_base.inverse() * Eigen::Vector2d(0, 0);
    const Eigen::Vector2d n = observation.line.normal(), t = observation.line.tangent();
    const double distance_m = observation.line.rho_m - n.dot(origin);
    const Eigen::Vector2d measured = origin + distance_m * n;

    FeaturePrediction f;
    if (predicted.norm() < nearest_foot_m || measured.norm() < nearest_foot_m) {
        f.innovation.setZero();
        f.H.pose.setZero();
        f.H.line.setZero();
        f.noise = 1e12 * Eigen::Matrix2d::Identity();
        return f;
    }
    f.innovation << measured.norm() - predicted.norm(), wrap_to_pi(bearing(measured) - bearing(predicted));
    f.H = foot_point_jacobians(T_map_base, line_map);
    Eigen::Matrix2d from_line;
    from_line.col(0) = n;
    from_line.col(1) = distance_m * t - t.dot(origin) * n;
    const Eigen::Matrix2d J = polar_jacobian(measured) * from_line;
    f.noise = J * covariance * J.transpose();
    return f;
}

}  // namespace

FeaturePrediction predict_feature(Feature feature, const Pose2& T_map_base, const PlanarLine& line_map,
                                  const Eigen::Vector2d& first_normal, const LineObservation& observation,
                                  const Eigen::Matrix2d& covariance) {
    if (feature == Feature::foot_point)
        return predict_foot_point(T_map_base, line_map, observation, covariance);
    return {innovation(observation.line, predicted_line(T_map_base, line_map)),
            observation_jacobians(T_map_base, line_map, first_normal), covariance};
}

ObservationJacobians feature_jacobians(Feature feature, const Pose2& T_map_base, const PlanarLine& line_map,
                                       const Eigen::Vector2d& first_normal) {
    if (feature == Feature::line) return observation_jacobians(T_map_base, line_map, first_normal);
    if ((line_map.point_m(0) - T_map_base.translation()).norm() < nearest_foot_m)
        return {Matrix23::Zero(), Eigen::Matrix2d::Zero()};
    return foot_point_jacobians(T_map_base, line_map);
}

}  // namespace loopline::line_slam
