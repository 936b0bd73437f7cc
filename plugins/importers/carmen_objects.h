/// MRPT's objects made of CARMEN's messages.
#pragma once

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>

#include "importers/carmen_log.h"

namespace loopline::carmen {

struct ScanProperties {
    StampNs stamp_ns = 0;
    double aperture_rad = 0;
    double min_range_m = 0;
    double max_range_m = 0;
    double sigma_range_m = 0;
    Pose2 T_base_laser;
};

/// Ranges that are not above the minimum, or not below the maximum, are kept and marked invalid.
mrpt::obs::CObservation2DRangeScan scan_observation(const Scan& scan, const ScanProperties& properties);

mrpt::obs::CObservationOdometry odometry_observation(const Pose2& T_odom_base, StampNs stamp_ns);
/// With its velocities.
mrpt::obs::CObservationOdometry odometry_observation(const Odometry& odometry, StampNs stamp_ns);

/// One motion, with the uncertainty of MRPT's Gaussian model at its defaults.
mrpt::obs::CActionCollection odometry_action(const Pose2& T_before_now, StampNs stamp_ns);

}  // namespace loopline::carmen
