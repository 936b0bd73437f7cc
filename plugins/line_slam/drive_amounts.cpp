#include "line_slam/drive_amounts.h"

#include <cmath>

namespace loopline::line_slam {
namespace {

/// Of one stretch.
struct Run {
    Regime regime = Regime::straight;
    double duration_s = 0;
    WheelValues way_m{};     ///< of the rims
    WheelValues rolled_m{};  ///< the same, forward and back
};

std::vector<Run> runs_of(const std::vector<CalibrationGraph::Piece>& pieces) {
    std::vector<Run> runs(pieces.size() > 1 ? static_cast<std::size_t>(pieces.back().stretch) + 1 : 0);
    for (std::size_t k = 1; k < pieces.size(); ++k) {
        Run& run = runs[static_cast<std::size_t>(pieces[k].stretch)];
        run.regime = pieces[k].drive.regime;
        run.duration_s += pieces[k].drive.duration_s;
        for (const Wheel wheel : both_wheels) {
            of(run.way_m, wheel) += of(pieces[k].drive.rolled, wheel);
            of(run.rolled_m, wheel) += std::abs(of(pieces[k].drive.rolled, wheel));
        }
    }
    return runs;
}

Estimate mean_speed(const std::vector<Run>& runs, Regime regime, Wheel wheel) {
    double way_m = 0, duration_s = 0, scatter_m2 = 0, n = 0;
    for (const Run& run : runs) {
        if (run.regime != regime) continue;
        way_m += of(run.way_m, wheel);
        duration_s += run.duration_s;
        ++n;
    }
    if (duration_s <= 0) return {};
    const double speed_mps = way_m / duration_s;
    for (const Run& run : runs)
        if (run.regime == regime)
            scatter_m2 += std::pow(of(run.way_m, wheel) - speed_mps * run.duration_s, 2);
    return {speed_mps, n > 1 ? std::sqrt(scatter_m2 * n / (n - 1)) / duration_s : std::abs(speed_mps)};
}

}  // namespace

RegimeAmounts amounts_of(const std::vector<CalibrationGraph::Piece>& pieces) {
    RegimeAmounts amounts;
    for (std::size_t k = 1; k < pieces.size(); ++k)
        ++amounts[static_cast<std::size_t>(pieces[k].drive.regime)].steps;
    const std::vector<Run> runs = runs_of(pieces);
    for (const Run& run : runs) {
        RegimeAmount& amount = amounts[static_cast<std::size_t>(run.regime)];
        ++amount.stretches;
        amount.duration_s += run.duration_s;
        for (const Wheel wheel : both_wheels) {
            of(amount.rolled_m, wheel) += of(run.rolled_m, wheel);
            of(amount.rolled_at_once_m, wheel) += of(run.rolled_m, wheel) * of(run.rolled_m, wheel);
        }
    }
    for (const Regime regime : all_regimes) {
        RegimeAmount& amount = amounts[static_cast<std::size_t>(regime)];
        for (const Wheel wheel : both_wheels) {
            if (of(amount.rolled_m, wheel) > 0)
                of(amount.rolled_at_once_m, wheel) /= of(amount.rolled_m, wheel);
            amount.speed_mps[static_cast<std::size_t>(wheel)] = mean_speed(runs, regime, wheel);
        }
    }
    return amounts;
}

}  // namespace loopline::line_slam
