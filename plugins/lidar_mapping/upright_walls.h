/// Which way is up, by the walls around: they stand upright, whatever the ground does. Neither the motion of
/// a lidar nor fixes along a straight street tell how far the vehicle leans to the side.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "lidar_mapping/surface_map.h"

namespace loopline::lidar_mapping {

struct Upright {
    Eigen::Vector3d up_map = Eigen::Vector3d::UnitZ();  ///< of length 1
    /// Of the turn, about the map's x and y, that up_map errs by: noise of the walls about their common
    /// upright, not what that itself leans.
    Eigen::Matrix2d covariance_rad2 = Eigen::Matrix2d::Zero();
    int walls = 0;
};

/// By the planes of the map that are within 15 degrees of upright; least squares under Cauchy's loss, as a
/// hedge or the side of a car leans. Walls that all face the same way tell nothing of the turn about their
/// normal, and the covariance says so. None if there are too few.
std::optional<Upright> upright_by_walls(const SurfaceMap& map);

}  // namespace loopline::lidar_mapping
