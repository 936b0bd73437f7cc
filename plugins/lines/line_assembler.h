/// From straight runs to published lines: maximum-likelihood fits, chains of chords dropped, collinear lines
/// merged and fitted again (Hu 2012, section 3.2, steps 3 and 4).
#pragma once

#include <vector>

#include "lines/extraction_parameters.h"
#include "lines/line_fit.h"
#include "lines/line_segment.h"
#include "lines/splitting.h"

namespace loopline::lines {

class LineAssembler {
 public:
    /// Replaces `segments` by the lines of the straight `pieces`, which are in the order of their beams.
    void assemble(const ScanPoints& points, const std::vector<Piece>& pieces, const NoiseModel& noise,
                  const ExtractionParameters& parameters, LineSegments& segments);

 private:
    struct Candidate {
        int label = 0;
        Interval run;     ///< from its first point to its last; others may lie between
        Moments moments;  ///< of its points
        LikelyFit fit;
        bool rejected = false;
        std::size_t first = 0;  ///< outermost points of the fit, in the order of bearing
        std::size_t last = 0;
        bool over_the_seam =
            false;  ///< in a full-circle scan: begins before its end and ends after its beginning
    };

    void extend(const ScanPoints& points, const NoiseModel& noise, const Piece& piece, Candidate& candidate);
    bool fit(const ScanPoints& points, const NoiseModel& noise, Candidate& candidate) const;
    void drop_chains_of_chords(const ScanPoints& points, const std::vector<Piece>& pieces,
                               const ExtractionParameters& parameters);
    void merge_collinear(const ScanPoints& points, const NoiseModel& noise,
                         const ExtractionParameters& parameters);
    bool merge(const ScanPoints& points, const NoiseModel& noise, const ExtractionParameters& parameters,
               Candidate& a, Candidate& b, bool over_the_seam);
    bool acceptable(const ScanPoints& points, const ExtractionParameters& parameters,
                    const Candidate& c) const;

    std::vector<Candidate> candidates_;
    std::vector<int> labels_;  ///< candidate of each point, -1 where none
};

}  // namespace loopline::lines
