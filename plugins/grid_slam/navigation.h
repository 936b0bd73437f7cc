/// Where the vehicle should be at a scan, before looking at it: by its wheels, by inertial navigation, or by
/// both (rows B3 and B4 of the method). What the scans say then is fed back.
#pragma once

#include <algorithm>

#include "api/stamp.h"
#include "grid_slam/motion.h"

namespace loopline::grid_slam {

/// At the time of a scan.
struct Prediction {
    StampNs stamp_ns = 0;
    Pose2 T_map_base;
    Eigen::Matrix3d covariance =
        Eigen::Matrix3d::Zero();  ///< of (x, y, phi) about the map around it, map axes
    Motion motion;                ///< since the scan before, without what scans say
    double duration_s = 0;        ///< since the scan before
};

/// What scans say about the pose errs as a whole with the map around it, so it is not new at each scan.
struct MapNoise {
    double sigma_m = 0.005;
    double sigma_rad = 0.1 * M_PI / 180;
    double lasts_s = 2;  ///< about as long as the vehicle goes by the same surfaces
    Eigen::Matrix3d covariance() const {
        return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
    }
    /// An error that stays for a while, for those who take it for new at each scan: of so many of them that
    /// their mean errs as it does.
    Eigen::Matrix3d covariance(double duration_s) const {
        return covariance() * (1 + lasts_s / std::clamp(duration_s, 0.01, lasts_s));
    }
};

}  // namespace loopline::grid_slam
