#include "lines/blockwise_extractor.h"

namespace loopline::lines {

void BlockwiseExtractor::extract(const PlanarScan& scan, LineSegments& segments) {
    points_.load(scan);
    noise_ = stated_noise(parameters_, scan.sigma_range_m);
    gap_splitter_.split(points_, noise_, blocks_);
    noise_.scale(noise_meter_.factor(points_, blocks_, noise_));
    pieces_.clear();
    for (const Interval& block : blocks_) {
        if (block.size() < static_cast<std::size_t>(parameters_.min_beams)) continue;
        const std::size_t before = pieces_.size();
        split(block);
        for (std::size_t i = before; i < pieces_.size(); ++i) pieces_[i].block = block;
    }
    assembler_.assemble(points_, pieces_, noise_, parameters_, segments);
}

}  // namespace loopline::lines
