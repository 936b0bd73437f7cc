/// How much of each regime a drive holds, and how fast its wheels turned in it.
#pragma once

#include "line_slam/calibration_graph.h"

namespace loopline::line_slam {

/// An estimate and its standard error.
struct Estimate {
    double value = 0;
    double standard_error = 0;
};

struct RegimeAmount {
    int steps = 0;      ///< of the filter, with a motion under this regime
    int stretches = 0;  ///< whose slip is one
    double duration_s = 0;
    WheelValues rolled_m{};          ///< way of the rims, forward and back
    WheelValues rolled_at_once_m{};  ///< within a stretch, as the mean over all metres: sum of squares by sum
    /// Of the rims: sum of the ways by sum of the times, starting and stopping included, with the scatter of
    /// the stretches as its error.
    std::array<Estimate, wheel_count> speed_mps;
};

using RegimeAmounts = std::array<RegimeAmount, regime_count>;

RegimeAmounts amounts_of(const std::vector<CalibrationGraph::Piece>& pieces);

}  // namespace loopline::line_slam
