/// Incremental extraction, also called line tracking: a line grows beam by beam as long as the next ones lie
/// on it.
#pragma once

#include "lines/blockwise_extractor.h"

namespace loopline::lines {

class Incremental : public BlockwiseExtractor {
 public:
    using BlockwiseExtractor::BlockwiseExtractor;

 protected:
    void split(const Interval& block) override;

 private:
    bool lies_on(const QuickFit& fit, double count, std::size_t point) const;
    /// End of the line that starts with the points of `seed`.
    std::size_t grow(const Interval& seed, std::size_t block_end) const;
};

}  // namespace loopline::lines
