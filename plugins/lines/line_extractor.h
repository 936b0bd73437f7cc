/// The interface that every line extraction method implements.
#pragma once

#include <memory>

#include "api/planar_scan.h"
#include "lines/extraction_parameters.h"
#include "lines/line_segment.h"

namespace loopline::lines {

class LineExtractor {
 public:
    virtual ~LineExtractor() = default;
    /// Replaces `segments` by the lines of `scan`, in the order of their first beam. Keeps working memory
    /// between calls; the result depends on the scan alone.
    virtual void extract(const PlanarScan& scan, LineSegments& segments) = 0;
};

/// The extractor of parameters.method.
std::unique_ptr<LineExtractor> make_line_extractor(const ExtractionParameters& parameters);

}  // namespace loopline::lines
