/// Where runs of points end: at range gaps, and at the best place to bend a line once.
#pragma once

#include <vector>

#include "lines/extraction_parameters.h"
#include "lines/noise_model.h"
#include "lines/scan_points.h"
#include "lines/straightness.h"

namespace loopline::lines {

/// A run that is straight, candidate for a line, or one smooth bend, kept for what it says about its
/// neighbours.
struct Piece {
    Interval run;
    Straightness shape;
    bool arc = false;
    Interval block = {};  ///< the run without gaps that it is part of
};

/// Hu 2012, section 3.2, step 1: runs without a gap wider than `max_gap_m`. Beams that meet a wall at a
/// grazing angle lie further apart than that without any gap, so up to `max_incidence_rad` their distance on
/// a wall is allowed, and four sigma of range noise (Borges and Aldon 2004).
class GapSplitter {
 public:
    explicit GapSplitter(const ExtractionParameters& parameters);
    /// Replaces `runs`. Those too short for a line and for a measurement of the noise are dropped. Keeps
    /// working memory.
    void split(const ScanPoints& points, const NoiseModel& noise, std::vector<Interval>& runs);

 private:
    const ExtractionParameters parameters_;
    const std::size_t shortest_;
    std::vector<double> excess_m2_;  ///< of the squared gap before a point over what is allowed
    std::vector<std::size_t> ends_;
};

/// The index b in (begin, end) for which two lines, through [begin, b) and [b, end), leave the least squares.
struct Break {
    std::size_t index = 0;
    double squares_m2 = 0;  ///< left by the two lines
};
Break best_break(const ScanPoints& points, const Interval& run);

/// Where few walls are in view, one recess in them may pass for noise in most of the scan, and a slanting
/// line through both its sides for straight. Told by what two lines leave of the residuals.
bool hides_a_step(const ScanPoints& points, const Interval& run, const Straightness& shape,
                  const NoiseModel& noise);

/// Splits runs without gaps at best breaks until every piece is straight or one bend.
class Splitter {
 public:
    explicit Splitter(const ExtractionParameters& parameters) : parameters_(parameters) {}

    /// Appends the pieces of `run` to `pieces`, in order. What is too short for a line is dropped.
    void split(const ScanPoints& points, const Interval& run, const NoiseModel& noise,
               std::vector<Piece>& pieces);

    /// Can a line come of these points at all?
    bool large_enough(const ScanPoints& points, const Interval& run) const;

 private:
    bool straight_or_small(const ScanPoints& points, const Interval& run, const NoiseModel& noise) const;
    bool is_arc(const ScanPoints& points, const Interval& run, const Straightness& shape, const Break& corner,
                const NoiseModel& noise) const;

    const ExtractionParameters parameters_;
    std::vector<Interval> stack_;
};

}  // namespace loopline::lines
