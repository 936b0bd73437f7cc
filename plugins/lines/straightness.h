/// Is a run of points a straight wall, a bent one, or neither? Decided from running sums alone.
#pragma once

#include "lines/noise_model.h"
#include "lines/quick_fit.h"

namespace loopline::lines {

/// Factor by which the mean square of `degrees_of_freedom` unit normal residuals stays below in all but 0.1 %
/// of cases. Wilson and Hilferty 1931.
double chi2_per_degree_limit(std::size_t degrees_of_freedom);

enum class Shape {
    straight,
    bent,    ///< the middle lies off the ends: a bend, or corners
    broken,  ///< steps or clutter, or corners that balance
};

struct Straightness {
    Shape shape = Shape::broken;
    QuickFit fit;
    double variance_m2 = 0;  ///< of the points across the line, as the noise model has it
    double sagitta_m =
        0;  ///< of the bend; positive where the middle lies beyond the line, seen from the sensor
    double sigma_sagitta_m = 0;  ///< from noise
};

/// `run` has at least three points. A wall may bow by `max_bow` of its length. Scatter beyond the model is
/// taken for noise up to a limit if it is disorderly: sweeps that lasers interleave from two turns of their
/// mirror, a few degrees of the vehicle's turn apart, leave walls with teeth.
Straightness straightness(const ScanPoints& points, const Interval& run, const NoiseModel& noise,
                          double max_bow);

/// Sum of the squared residuals that a parabola over the line leaves of a run: little of a smooth bend.
double squares_left_by_parabola_m2(const ScanPoints& points, const Interval& run, const NormalForm& line);

}  // namespace loopline::lines
