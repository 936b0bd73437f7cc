/// What a scan matcher says of a planar pose, where it may say nothing along some direction.
#pragma once

#include <Eigen/Core>

#include "api/pose2.h"

namespace loopline::inertial {

/// Log-likelihood around `T_map_base`: gradient' d - d' information d / 2, with d = (dx, dy, dphi) added to
/// it, in the map frame (m, m, rad). In a corridor the information is singular.
struct PlanarInformation {
    Pose2 T_map_base;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// A direction with information: `direction`' d = `value`, with `variance`.
struct KnownDirection {
    Eigen::Vector3d direction;
    double value;
    double variance;
};

/// At most three, of independent errors; those known worse than `vaguest_sigma` are left out. One metre
/// counts like one radian in what "direction" means; what has no information at all has none in any unit.
struct KnownDirections {
    int count = 0;
    KnownDirection at[3];
};
KnownDirections known_directions(const PlanarInformation& pose, double vaguest_sigma);

}  // namespace loopline::inertial
