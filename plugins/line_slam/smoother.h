/// After the log: the whole path and map at once, with the pairings looked at again from the better path.
#pragma once

#include <vector>

#include "line_slam/history.h"

namespace loopline::line_slam {

struct SmootherParameters {
    int rounds = 4;                  ///< of least squares and new pairing, at most
    int max_iterations = 25;         ///< of least squares, each round
    double robust_scale = 3;         ///< Cauchy loss on whitened residuals
    double association_gate = 13.8;  ///< squared Mahalanobis distance of two degrees of freedom
    double max_gap_m = 1.0;
    int min_observations = 3;    ///< a line seen by fewer scans is left out
    double merge_gate_m = 0.10;  ///< two lines closer than this over their common stretch are one
    double sigma_wall_m = 0.01;
};

struct SmoothedLine {
    PlanarLine line;
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
    Extent extent;
    int observations = 0;
    int track = 0;
};

struct SmoothedMap {
    std::vector<Pose2> poses;                  ///< one for each step of the history
    std::vector<Eigen::Matrix3d> covariances;  ///< of (x, y, phi)
    std::vector<SmoothedLine> lines;
    WheelCalibration calibration;
    bool good = false;  ///< false: least squares failed, the poses are the filter's
    int rounds = 0, iterations = 0, merged = 0;
    double initial_cost = 0, final_cost = 0;
};

SmoothedMap smooth(const History& history, const SmootherParameters& parameters);

}  // namespace loopline::line_slam
