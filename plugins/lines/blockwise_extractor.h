/// What all methods share: gaps first, then blocks into straight pieces by the method's own way, then lines
/// of pieces.
#pragma once

#include "lines/extraction_parameters.h"
#include "lines/line_assembler.h"
#include "lines/line_extractor.h"

namespace loopline::lines {

class BlockwiseExtractor : public LineExtractor {
 public:
    explicit BlockwiseExtractor(const ExtractionParameters& parameters)
        : parameters_(parameters), splitter_(parameters), gap_splitter_(parameters) {}
    void extract(const PlanarScan& scan, LineSegments& segments) final;

 protected:
    /// Appends the straight pieces of `block`, a run without gaps, to `pieces_`, in order.
    virtual void split(const Interval& block) = 0;
    void split_rest(const Interval& run) { splitter_.split(points_, run, noise_, pieces_); }

    const ExtractionParameters parameters_;
    ScanPoints points_;
    NoiseModel noise_;
    std::vector<Piece> pieces_;
    Splitter splitter_;

 private:
    std::vector<Interval> blocks_;
    GapSplitter gap_splitter_;
    NoiseMeter noise_meter_;
    LineAssembler assembler_;
};

}  // namespace loopline::lines
