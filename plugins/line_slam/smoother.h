/// After the log: the whole path and map at once, with the pairings looked at again from the better path.
#pragma once

#include <vector>

#include "line_slam/wall_map.h"

namespace loopline::line_slam {

struct SmootherParameters {
    int rounds = 3;            ///< of least squares and new pairing, at most
    int early_iterations = 4;  ///< of least squares in all rounds but the last
    int last_iterations = 20;
    double robust_scale = 3;  ///< Cauchy loss on whitened residuals
    PairingParameters pairing;
    int min_observations = 3;        ///< a wall seen by fewer scans is left out
    double merge_distance_m = 0.10;  ///< two walls closer than this over the shorter one's length are one
};

struct SmoothedWall {
    Wall wall;
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (rho, alpha)
};

struct SmoothedPath {
    bool good = false;         ///< false: least squares failed; the filter's path holds, the rest is empty
    std::vector<Pose2> poses;  ///< one for each step of the history
    std::vector<Eigen::Matrix3d> covariances;  ///< of (x, y, phi)
    std::vector<SmoothedWall> walls;           ///< ordered by track
    Pairings pairings;                         ///< that this is the path of
    WheelCalibration calibration;
    int rounds = 0, iterations = 0;
    double initial_cost = 0, final_cost = 0;
};

SmoothedPath smooth(const History& history, const SmootherParameters& parameters);

}  // namespace loopline::line_slam
