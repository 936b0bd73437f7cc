/// From straight runs to published lines: maximum-likelihood fits, chains of chords dropped, collinear lines
/// merged and fitted again (Hu 2012, section 3.2, steps 3 and 4).
#pragma once

#include <vector>

#include "lines/extraction_parameters.h"
#include "lines/line_candidate.h"
#include "lines/line_segment.h"
#include "lines/splitting.h"

namespace loopline::lines {

class LineAssembler {
 public:
    /// Replaces `segments` by the lines of the straight `pieces`, which are in the order of their beams.
    void assemble(const ScanPoints& points, const std::vector<Piece>& pieces, const NoiseModel& noise,
                  const ExtractionParameters& parameters, LineSegments& segments);

 private:
    void start(const QuickFit& quick, const Moments& moments, const NoiseModel& noise);
    bool refit(const ScanPoints& points, const NoiseModel& noise, const QuickFit& together,
               LineCandidate& candidate);
    void merge_collinear(const ScanPoints& points, const NoiseModel& noise,
                         const ExtractionParameters& parameters);
    bool merge(const ScanPoints& points, const NoiseModel& noise, const ExtractionParameters& parameters,
               LineCandidate& a, LineCandidate& b, bool over_the_seam);
    bool acceptable(const ScanPoints& points, const ExtractionParameters& parameters,
                    const LineCandidate& c) const;

    std::vector<LineCandidate> candidates_;  ///< one of each piece
    LineFitter fitter_;
};

}  // namespace loopline::lines
