/// A drive's calibration as keys of section [line_slam].
#pragma once

#include "api/results.h"
#include "line_slam/calibration.h"

namespace loopline::line_slam {

/// What the calibrated run was told.
struct CalibratedRun {
    DriveParameters drive;
    Regimes regimes;
    IntervalParameters::Control control = IntervalParameters::Control::measured;
    bool regimes_from_log = false;  ///< they were commanded, and not guessed from the wheels' speeds
};

/// Keys that the log tells no better than the run was told are left out, with the reason.
Calibration calibration_section(const DriveCalibration& calibration, const CalibratedRun& run);

}  // namespace loopline::line_slam
