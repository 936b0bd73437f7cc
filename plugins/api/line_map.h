/// A map of straight walls, as estimators hand it to the writers and pictures.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace loopline {

/// A wall: the line x cos(alpha) + y sin(alpha) = rho in the map frame, and the part of it that was seen.
struct MapLine {
    std::uint64_t id = 0;
    double rho_m = 0;                                            ///< signed distance of the line from the origin
    double alpha_rad = 0;                                        ///< direction of its normal
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();        ///< of (rho, alpha): m^2, m rad, rad^2
    Eigen::Vector2d start_m = Eigen::Vector2d::Zero();           ///< end points, on the line, map frame
    Eigen::Vector2d end_m = Eigen::Vector2d::Zero();
    int observations = 0;                                        ///< scans that saw it
};

using LineMap = std::vector<MapLine>;

}  // namespace loopline
