/// A drive's wheels and noise as one round of calibration assumes them, and what that makes of the history.
#pragma once

#include <vector>

#include "line_slam/calibration_graph.h"
#include "line_slam/smoother.h"

namespace loopline::line_slam {

/// What the control was, for each step of a history since the step before it.
using Drive = std::vector<std::vector<DrivePiece>>;

struct AssumedDrive {
    RegimeWheelValues slip{};
    double track_width_m = 0.5;
    NoiseVector log_variance = NoiseVector::Zero();

    /// Without the noise.
    WheelTravel over_ground(const DrivePiece& piece) const;
    /// Of (left, right, side), without the scatter of slip.
    Eigen::Matrix3d covariance(const DrivePiece& piece) const;
};

/// The history with its motions as assumed, and its poses at `path` unless that is empty.
History history_with(const AssumedDrive& assumed, const Drive& drive, const History& history,
                     const SmoothedPath& path);

}  // namespace loopline::line_slam
