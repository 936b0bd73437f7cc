/// Whether the vehicle still stands where it stood in the first sweep, by the ranges of each beam alone: no
/// map is needed for that, and no model of noise. On a field, which holds a sweep badly, it sees a start
/// first.
#pragma once

#include <array>
#include <vector>

#include "lidar/spinning_scan.h"

namespace loopline::lidar_mapping {

class Standstill {
 public:
    /// Ranges of one ring in a piece of its turn.
    struct Piece {
        double n = 0, sum_m = 0, squares_m2 = 0;
    };
    /// Squares of the changes of the pieces in a sector, in standard deviations by the scatter within a
    /// piece. That holds the shape of what is seen too, so those of a vehicle that stands are smaller than 1.
    struct Changes {
        double n = 0, sum = 0, squares = 0;
        double mean() const { return sum / n; }
        double variance_of_mean() const { return (squares / n - mean() * mean()) / n; }
    };
    static constexpr int sectors = 24;

    /// True as long as nothing has changed since the first sweep. The sweep is learnt from if it is one of
    /// the first few.
    bool lasts(const lidar::SpinningScan& scan);

 private:
    template <class Archive>
    friend void fields(Archive&, Standstill&);
    using BySector = std::array<Changes, sectors>;
    void measure(const lidar::SpinningScan& scan);
    BySector changes() const;
    static bool drives_from_the_first(const BySector& changes);
    bool has_left(const BySector& changes) const;
    void learn(const BySector& changes);

    std::vector<Piece> now_, learnt_;
    BySector usual_;  ///< while it stands
    int sweeps_ = 0;
};

}  // namespace loopline::lidar_mapping
