/// The noise that makes a drive's measurements likeliest.
#pragma once

#include "line_slam/calibration_graph.h"

namespace loopline::line_slam {

/// What is believed before the log: a normal distribution of the variances' logarithms.
struct NoisePrior {
    NoiseVector mean = NoiseVector::Zero();
    NoiseMatrix information = NoiseMatrix::Zero();

    double cost(const NoiseVector& log_variance) const {
        const NoiseVector d = log_variance - mean;
        return d.dot(information * d);
    }
};

struct NoiseEstimate {
    bool good = false;
    NoiseVector log_variance = NoiseVector::Zero();
    NoiseMatrix covariance = NoiseMatrix::Zero();  ///< of the logarithms
};

/// Maximum of likelihood times prior by Newton's method with the average information (Gilmour, Thompson and
/// Cullis 1995). `graph` is at its minimum for that noise afterwards.
NoiseEstimate likeliest_noise(CalibrationSolver& solver, CalibrationGraph& graph, const NoiseVector& start,
                              const NoisePrior& prior);

}  // namespace loopline::line_slam
