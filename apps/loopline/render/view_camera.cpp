/// The eye on a sphere round the target, and the two projections.
#include "render/view_camera.h"

#include <algorithm>
#include <cmath>

namespace loopline {
namespace {
double radians(double angle_deg) {
    return angle_deg * M_PI / 180;
}
}  // namespace

Eigen::Vector3d ViewCamera::direction_to_eye() const {
    const double azimuth = radians(azimuth_deg), elevation = radians(elevation_deg);
    return {std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
            std::sin(elevation)};
}

Eigen::Vector3d ViewCamera::right() const {
    const double azimuth = radians(azimuth_deg);
    return {-std::sin(azimuth), std::cos(azimuth), 0};
}

Eigen::Vector3d ViewCamera::up() const {
    const double azimuth = radians(azimuth_deg), elevation = radians(elevation_deg);
    return {-std::cos(azimuth) * std::sin(elevation), -std::sin(azimuth) * std::sin(elevation),
            std::cos(elevation)};
}

double ViewCamera::px_per_m(double height_px) const {
    return parallel ? height_px / visible_height_m
                    : height_px / (2 * distance_m * std::tan(radians(field_of_view_deg) / 2));
}

Eigen::Vector2d ViewCamera::pixel(const Eigen::Vector3d& p_map, double width_px, double height_px) const {
    const Eigen::Vector3d d = p_map - target_m;
    const double depth_share = parallel ? 1 : 1 - d.dot(direction_to_eye()) / distance_m;
    const double scale = px_per_m(height_px) / depth_share;
    return {width_px / 2 + scale * d.dot(right()), height_px / 2 - scale * d.dot(up())};
}

ViewCamera axonometric_camera(const SceneContent& content, double wall_height_m, double width_px,
                              double height_px) {
    constexpr double margin = 1.08;
    ViewCamera camera;
    camera.azimuth_deg = -65;
    camera.elevation_deg = 52;
    const Bounds whole = bounds_of(content);
    if (whole.empty()) return camera;

    // The content in the camera's own axes (right, up, towards the eye), where what it covers is a box again.
    Eigen::Matrix3d R_camera_map;
    R_camera_map << camera.right().transpose(), camera.up().transpose(),
        camera.direction_to_eye().transpose();
    SceneContent turned;
    for (const auto* path : {&content.estimated_path, &content.odometry_path})
        for (const auto& pose : *path)
            turned.estimated_path.emplace_back(R_camera_map * pose.translation_m,
                                               Eigen::Quaterniond::Identity());
    for (const auto& p : content.points_m)
        turned.points_m.push_back((R_camera_map * p.cast<double>()).cast<float>());
    for (const auto& line : content.lines.value_or(LineMap{}))
        for (const auto& end_m : {line.start_m, line.end_m})
            for (const double height_m : {0.0, wall_height_m})
                turned.estimated_path.emplace_back(
                    R_camera_map * Eigen::Vector3d(end_m.x(), end_m.y(), height_m),
                    Eigen::Quaterniond::Identity());
    Bounds seen = bounds_of(turned);
    if (seen.empty()) {
        seen.add(R_camera_map * whole.low_m);
        seen.add(R_camera_map * whole.high_m);
    }

    const Eigen::Vector3d extent_m = seen.extent_m().cwiseMax(1.0);
    camera.target_m = R_camera_map.transpose() * seen.centre_m();
    camera.visible_height_m = margin * std::max(extent_m.y(), extent_m.x() * height_px / width_px);
    // Stray points outside of the bounds may be anywhere in the visible part.
    const double reach_m = extent_m.z() / 2 + camera.visible_height_m * std::max(1.0, width_px / height_px);
    camera.distance_m = 1.1 * reach_m;
    camera.near_m = 0.1 * reach_m;
    camera.far_m = 2.1 * reach_m;
    return camera;
}

ViewCamera follow_camera(const Pose3& T_map_base, const Bounds& bounds) {
    const double extent_m = bounds.empty() ? 10 : bounds.extent_m().norm();
    ViewCamera camera;
    camera.parallel = false;
    camera.field_of_view_deg = 50;
    camera.distance_m = std::clamp(0.15 * extent_m, 4.0, 7.0);
    camera.azimuth_deg = T_map_base.yaw_rad() * 180 / M_PI + 180;
    camera.elevation_deg = 27;
    const Eigen::Vector3d ahead(std::cos(T_map_base.yaw_rad()), std::sin(T_map_base.yaw_rad()), 0);
    camera.target_m = T_map_base.translation_m + 0.3 * camera.distance_m * ahead;
    camera.near_m = 0.2 * camera.distance_m;
    camera.far_m = std::min(60 * camera.distance_m, 1.3 * extent_m + 2 * camera.distance_m);
    return camera;
}

}  // namespace loopline
