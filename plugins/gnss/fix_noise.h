/// What the position of a fix is worth: errors of satellite positions are white in a small part only, and a
/// receiver's own opinion of them is not to be trusted when it is better than its kind of fix can be.
#pragma once

#include <Eigen/Core>

#include "gnss/gnss_fix.h"

namespace loopline::gnss {

/// Of east and of north each.
struct FixNoise {
    double white_m = 0;
    double correlated_m = 0;   ///< of an error that wanders: a Gauss-Markov process
    double correlation_s = 1;  ///< its time constant
};

struct FixNoiseSettings {
    FixNoise fixed{0.01, 0.004, 60}, floating{0.05, 0.35, 60}, differential{0.25, 0.8, 60},
        single{0.4, 2, 45};
    double vertical_factor = 2;  ///< errors of the height are so many times those
    double sigma_velocity_mps =
        0.3;  ///< of a velocity by Doppler shifts, east and north each: its errors last, and it lags
};

/// Standard deviations along east, north, up.
struct SigmaOfFix {
    Eigen::Vector3d white_m = Eigen::Vector3d::Zero(), correlated_m = Eigen::Vector3d::Zero();
    double correlation_s = 1;
};

/// By the kind of fix, or as much more as the receiver says; in proportion, since it tells the sum of both.
SigmaOfFix sigma_of(const GnssFix& fix, const FixNoiseSettings& settings);

/// Kinds of fix whose slow error is one and the same process.
enum class ErrorProcess { none, fixed, floating, differential, single };
ErrorProcess process_of(FixQuality quality);

}  // namespace loopline::gnss
