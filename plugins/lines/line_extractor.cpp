#include "lines/line_extractor.h"

#include "lines/angle_threshold.h"
#include "lines/incremental.h"
#include "lines/split_and_merge.h"

namespace loopline::lines {

std::unique_ptr<LineExtractor> make_line_extractor(const ExtractionParameters& parameters) {
    switch (parameters.method) {
        case Method::split_and_merge:
            return std::make_unique<SplitAndMerge>(parameters);
        case Method::incremental:
            return std::make_unique<Incremental>(parameters);
        case Method::angle_threshold:
            break;
    }
    return std::make_unique<AngleThreshold>(parameters);
}

}  // namespace loopline::lines
