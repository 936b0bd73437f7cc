/// Split and merge (Pavlidis and Horowitz 1974, in the form that lasers made common): a block is split where
/// two lines fit it best, until every part is straight.
#pragma once

#include "lines/blockwise_extractor.h"

namespace loopline::lines {

class SplitAndMerge : public BlockwiseExtractor {
 public:
    using BlockwiseExtractor::BlockwiseExtractor;

 protected:
    void split(const Interval& block) override { split_rest(block); }
};

}  // namespace loopline::lines
