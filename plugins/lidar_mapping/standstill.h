/// Whether the vehicle still stands where it stood in the first sweep, by the ranges of each beam alone: no
/// map is needed for that, and no model of noise.
#pragma once

#include <vector>

#include "lidar/spinning_scan.h"

namespace loopline::lidar_mapping {

class Standstill {
 public:
    /// Ranges of one ring in a piece of its turn.
    struct Piece {
        double n = 0, sum_m = 0, squares_m2 = 0;
    };
    /// True as long as nothing has changed since the first sweep. The sweep is learnt from if it is one of
    /// the first few.
    bool lasts(const lidar::SpinningScan& scan);

 private:
    template <class Archive>
    friend void fields(Archive&, Standstill&);
    void measure(const lidar::SpinningScan& scan);
    double change() const;

    std::vector<Piece> now_, learnt_;
    int sweeps_ = 0;
};

}  // namespace loopline::lidar_mapping
