/// All that happened, scan by scan: what the smoother works on.
#pragma once

#include <deque>
#include <utility>
#include <vector>

#include "line_slam/motion_model.h"
#include "line_slam/planar_line.h"

namespace loopline::line_slam {

constexpr int no_track = -1;

struct HistoryStep {
    WheelTravel travel;  ///< since the previous step, as measured: of one arc, whatever the pieces were
    Eigen::Matrix3d travel_covariance = Eigen::Matrix3d::Zero();
    Pose2 T_map_base;  ///< what the filter knew
    std::vector<LineObservation> observations;
    std::vector<int> tracks;  ///< per observation: which wall, or no_track
};

struct History {
    std::deque<HistoryStep>
        steps;  ///< never moved: a step of the filter takes the same time, however many there were
    int track_count = 0;
    std::vector<std::pair<int, int>> same_wall;  ///< tracks that were recognised as one
    DriveParameters drive;
    WheelCalibration calibration;  ///< by the filter, at last
};

}  // namespace loopline::line_slam
