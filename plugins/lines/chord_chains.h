/// Round walls fall into chains of chords; none of these is a wall.
#pragma once

#include <vector>

#include "lines/extraction_parameters.h"
#include "lines/line_candidate.h"
#include "lines/splitting.h"

namespace loopline::lines {

/// A round wall falls into chords that touch and turn a little from one to the next. Two neighbours of
/// lengths a, b that turn by delta suggest the curvature delta / ((a + b) / 2), a bend with sagitta s over
/// length l the curvature 8 s / l^2. A chord of such an arc has a sagitta that its own points would show:
/// what does not show itself straighter than half of that, and would turn noticeably, is no wall. Bends
/// flatter than a radius of 20 m are wobbling walls.
/// `candidates[i]` comes from `pieces[i]`; those that may be chords are marked as rejected.
void drop_chains_of_chords(const ScanPoints& points, const std::vector<Piece>& pieces,
                           const ExtractionParameters& parameters, std::vector<LineCandidate>& candidates);

}  // namespace loopline::lines
