/// From a history and its smoothed path to the least squares that a calibration works on.
#pragma once

#include "line_slam/assumed_drive.h"

namespace loopline::line_slam {

struct DriveGraphParameters {
    double gate = 13.8;  ///< squared distance of an observation from its wall; outliers would pass for noise
    double wall_correlation_m = 2;  ///< of the path, over which a wall's unevenness looks the same
    double longest_stretch_m = 5;   ///< of the way under one regime, over which slip is taken for constant
};

/// A wall is seen as one *patch* after the other, each a line that is as far from the wall as the wall is
/// uneven: what the next scans repeat is no news, and what they measure anew is.
CalibrationGraph graph_of_drive(const History& history, const SmoothedPath& path, const Drive& drive,
                                const AssumedDrive& assumed, const DriveGraphParameters& parameters);

}  // namespace loopline::line_slam
