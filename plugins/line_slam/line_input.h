/// From an extracted segment (sensor frame) to the filter's observation (base frame), with the noise that
/// real walls add.
#pragma once

#include "line_slam/planar_line.h"
#include "lines/line_segment.h"

namespace loopline::line_slam {

/// The fit's covariance knows of range noise alone. Walls are not straight either: each end of what is seen
/// lies `sigma_wall_m` off the ideal line, independently, which moves the middle by sigma / sqrt(2) and turns
/// the line by sqrt(2) sigma / length.
LineObservation observation_in_base(const lines::LineSegment& segment, const Pose2& T_base_sensor,
                                    double sigma_wall_m);

}  // namespace loopline::line_slam
