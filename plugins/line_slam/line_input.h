/// From an extracted segment (sensor frame) to the filter's observation (base frame), with the noise that
/// real walls add, and without the skew that the vehicle's motion during a sweep brings in.
#pragma once

#include "api/twist2.h"
#include "line_slam/planar_line.h"
#include "lines/line_segment.h"

namespace loopline::line_slam {

/// The fit's covariance knows of range noise alone. Walls are not straight either: each end of what is seen
/// lies `sigma_wall_m` off the ideal line, independently, which moves the middle by sigma / sqrt(2) and turns
/// the line by sqrt(2) sigma / length.
LineObservation observation_in_base(const lines::LineSegment& segment, const Pose2& T_base_sensor,
                                    double sigma_wall_m);

/// When a laser measures each beam of a sweep, after the scan's stamp.
struct SweepTime {
    double duration_s =
        0;  ///< from the first beam, counter-clockwise, to the last; < 0: the last comes first
    std::size_t beams = 0;

    double after_stamp_s(std::size_t beam) const {
        const double part = beams > 1 ? static_cast<double>(beam) / static_cast<double>(beams - 1) : 0;
        return duration_s < 0 ? -duration_s * (1 - part) : duration_s * part;
    }
};

/// How a vehicle moves during a sweep.
struct SweepMotion {
    Twist2 velocity_base;                                   ///< per second
    Eigen::Matrix3d noise_per_s = Eigen::Matrix3d::Zero();  ///< covariance of (x, y, phi) that a second adds
};

/// The observation as if all beams had been measured at the scan's stamp: each end is put where it was, and
/// the line goes through both. What the vehicle's motion is not known to is noise of the observation.
void deskew(const lines::LineSegment& segment, const SweepTime& sweep, const SweepMotion& motion,
            LineObservation& z);

}  // namespace loopline::line_slam
