/// The maximum-likelihood line with its covariance, which is published. Derivation: docs/papers/lines.md.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lines/noise_model.h"
#include "lines/normal_equations.h"
#include "lines/quick_fit.h"
#include "lines/scan_points.h"

namespace loopline::lines {

/// The normal form with the greatest likelihood under the noise model.
struct LikelyFit {
    bool valid = false;
    NormalForm line;
    Eigen::Matrix2d covariance =
        Eigen::Matrix2d::Zero();  ///< of (rho, alpha), for the noise as the model has it
    double chi2 = 0;              ///< of the points in the fit
    double rms_m = 0;
    double autocorrelation = 0;  ///< of the residuals of neighbouring points
    std::size_t count = 0;       ///< points in the fit
    std::size_t ends = 0;        ///< points beyond them that lie on the line as well
    std::size_t first = 0;       ///< outermost of all these
    std::size_t last = 0;
};

/// Fits the lines of a scan side by side: no step of one waits for another's.
class LineFitter {
 public:
    void clear();
    /// A line to fit, starting from `start`. `variance_factor` says by how much residuals exceed the model,
    /// for the gate only.
    void add_line(const NormalForm& start, double variance_factor);
    /// Points of the line added last. Runs come in order; those that touch become one.
    void add_run(const Interval& run);
    /// Points off by more than three sigma have no part in the fits, and ends that hang off the line are cut,
    /// so that corners and mixed pixels don't drag it. The outermost beams of every run say where the line
    /// ends, not where it is: see set_ends_apart().
    void fit(const ScanPoints& points, const NoiseModel& noise);
    /// In the order in which the lines were added.
    const LikelyFit& operator[](std::size_t i) const { return lines_[i].fit; }

 private:
    struct Line {
        LikelyFit fit;
        double variance_factor;
        std::size_t first_run, end_run;    ///< in runs_
        std::size_t first, last;           ///< outermost points that lie on it
        std::size_t first_slot, end_slot;  ///< in weights_ and residuals_m_
        NormalEquations sums;
    };
    void prepare(const ScanPoints& points);
    void cut_hanging_ends(const ScanPoints& points, const NoiseModel& noise, Line& line);
    void set_ends_apart(const ScanPoints& points, const NoiseModel& noise, Line& line);
    void sum_up(const ScanPoints& points, const NoiseModel& noise, Line& line);
    static bool step(Line& line);
    void describe_residuals(Line& line);
    void find_ends(const ScanPoints& points, const NoiseModel& noise, Line& line) const;
    std::size_t first_in_fit(const Line& line) const;
    std::size_t last_in_fit(const Line& line) const;

    std::vector<Line> lines_;
    std::vector<std::size_t> open_;  ///< lines that take another step
    std::vector<Interval> runs_;     ///< of all lines
    // Of the points of all lines: each run has as many slots as it has points, rounded up, and an empty one.
    std::vector<double> weights_, residuals_m_;
    std::vector<double> ones_;  ///< as many as there are points, then zeros
};

}  // namespace loopline::lines
