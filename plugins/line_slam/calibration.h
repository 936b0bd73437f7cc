/// Slip, track width and noise of a drive, regime by regime, from a log that the line SLAM has gone through:
/// what Hu, Chen, Zhang 2012, figure 3, has a person choose. Derivation: docs/papers/calibration.md.
#pragma once

#include "line_slam/drive_amounts.h"
#include "line_slam/graph_of_drive.h"

namespace loopline::line_slam {

struct CalibrationParameters {
    Regimes regimes;  ///< as they were presumed while the history was made
    SmootherParameters smoother;
    DriveGraphParameters graph;
    int rounds = 6;         ///< of smoothing with what the round before found, at most
    double settled = 0.05;  ///< a round that changes all slips by less of their standard errors is the last
    // Presumed of the noise, each within a factor: one standard deviation of the logarithm.
    double factor_noise = 10;       ///< as `regimes` and the history's drive say
    double factor_wheels = 2;       ///< the wheels of one regime are alike
    double likely_scatter = 0.003;  ///< of slip from stretch to stretch
    double factor_scatter = 10;
    double likely_rest_m = 2e-5;  ///< noise that no way explains
    double factor_rest = 5;
    /// The log tells the track width if its standard error is below so much of what is presumed of it.
    double track_told = 0.5;
};

/// A noise that is not known within a factor of two is not told.
constexpr double largest_relative_error = 0.7;

struct WheelEstimate {
    Estimate slip;
    /// Of the travel after 1 m, as a filter takes it that knows no scatter of slip: where the log tells the
    /// scatter, right for whole stretches, otherwise the likeliest white noise.
    Estimate sigma_m;
    Estimate random_way_m;  ///< of the travel after 1 m, beside the scatter of slip
    Estimate scatter;       ///< of slip from stretch to stretch

    bool scatter_is_told() const { return scatter.standard_error < largest_relative_error * scatter.value; }
};

struct DriveCalibration {
    bool good = false;
    std::array<std::array<WheelEstimate, wheel_count>, regime_count> wheels;
    RegimeAmounts amounts;
    bool track_told = false;  ///< if not, slip holds for the stated track width
    Estimate track_width_m;   ///< stated, with the standard error by the log, if it is not told
    Estimate sigma_side_m, sigma_rest_m;
    Estimate delay_s;  ///< of the scans behind the times of their poses
    int rounds = 0;

    const WheelEstimate& wheel(Regime regime, Wheel wheel) const {
        return wheels[static_cast<std::size_t>(regime)][static_cast<std::size_t>(wheel)];
    }
};

DriveCalibration calibrate_drive(const History& history, const Drive& drive,
                                 const CalibrationParameters& parameters);

}  // namespace loopline::line_slam
