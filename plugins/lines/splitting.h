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
};

/// Hu 2012, section 3.2, step 1: runs without a gap wider than `max_gap_m`. Beams that meet a wall at a
/// grazing angle lie further apart than that without any gap, so up to `max_incidence_rad` their distance on
/// a wall is allowed, and four sigma of range noise (Borges and Aldon 2004).
void split_at_gaps(const ScanPoints& points, const ExtractionParameters& parameters, const NoiseModel& noise,
                   std::vector<Interval>& runs);

/// The index b in (begin, end) for which two lines, through [begin, b) and [b, end), leave the least squares.
std::size_t best_break(const ScanPoints& points, const Interval& run);

/// Splits at best breaks until every piece is straight; bends and remainders of less than three points are
/// dropped. Appends to `pieces` in order. `stack` is working memory.
void split_until_straight(const ScanPoints& points, const Interval& run, const NoiseModel& noise,
                          double max_bow, std::vector<Piece>& pieces, std::vector<Interval>& stack);

}  // namespace loopline::lines
