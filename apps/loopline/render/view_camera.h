/// Where a spatial picture is looked at from, and where a point of the map falls on it.
#pragma once

#include <Eigen/Core>

#include "render/content_bounds.h"

namespace loopline {

/// A camera that looks at a point from a direction; the picture's up is the map's, as far as it goes.
struct ViewCamera {
    Eigen::Vector3d target_m = Eigen::Vector3d::Zero();
    double azimuth_deg = 0;         ///< direction from target to eye, counter-clockwise from x
    double elevation_deg = 45;      ///< of the eye above the horizon, below 90
    double distance_m = 10;         ///< from target to eye
    bool parallel = true;           ///< parallel projection, or a perspective one
    double visible_height_m = 10;   ///< of a parallel projection
    double field_of_view_deg = 50;  ///< of a perspective one, vertical
    double near_m = 1,
           far_m = 100;  ///< what is nearer or farther is not drawn; tight, for the sake of depth resolution

    Eigen::Vector3d direction_to_eye() const;
    Eigen::Vector3d right() const;
    Eigen::Vector3d up() const;
    /// Picture coordinates of a point (x right, y down, in pixels), for a picture of this size.
    Eigen::Vector2d pixel(const Eigen::Vector3d& p_map, double width_px, double height_px) const;
    /// Pixels per metre, across the line of sight at the target.
    double px_per_m(double height_px) const;
};

/// All of the content, with walls raised by `wall_height_m`, seen from aside and above in parallel
/// projection.
ViewCamera axonometric_camera(const SceneContent& content, double wall_height_m, double width_px,
                              double height_px);

/// From behind and above a vehicle, in perspective; `bounds` is what there is to see.
ViewCamera follow_camera(const Pose3& T_map_base, const Bounds& bounds);

}  // namespace loopline
