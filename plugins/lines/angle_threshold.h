/// Hu 2012, section 3.2, step 2: a block is split where the chords on both sides of a point enclose more than
/// an angle.
///
/// The paper takes the chords to the next points. At 0.1 m between points and 1 cm of noise, such chords turn
/// by 14 degrees (one sigma) on a straight wall. A chord of m points and length W, taken as their
/// least-squares direction, has
///
///     sigma(direction) = sigma_normal sqrt(12 / m) / W,
///
/// so here the chords grow until the turn between them is known to a quarter of the threshold, and no
/// further: a longer chord reaches over short walls. They come from running sums, so their length costs
/// nothing.
#pragma once

#include "lines/blockwise_extractor.h"

namespace loopline::lines {

class AngleThreshold : public BlockwiseExtractor {
 public:
    explicit AngleThreshold(const ExtractionParameters& parameters);

 protected:
    void split(const Interval& block) override;

 private:
    /// The turn at a point between the chords before and after it.
    struct Turn {
        double sin2 = 0;  ///< squared sine of the angle between the chords; above 1 where the path turns back
        double variance = 0;  ///< of the angle
        std::size_t point = 0;
        std::size_t chord_points = 0;  ///< of each chord, the point between them counted in both
    };
    Turn turn_at(const Interval& block, std::size_t point, std::size_t chord_points) const;
    void find_corners(const Interval& block);

    double sin2_threshold_;
    double wanted_variance_;  ///< of a turn
    std::vector<Turn> turns_, corners_;
};

}  // namespace loopline::lines
