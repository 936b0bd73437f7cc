/// The path of a loop from the two ways it was found (row B10: "weighted sum of the forward and the reverse
/// positions").
#pragma once

#include "grid_slam/reverse_pass.h"

namespace loopline::grid_slam {

enum class Weights {
    linear,      ///< the patent's: 1 - i/n forward, i/n in reverse, whatever either is worth
    covariance,  ///< by their information: the two-filter smoother of Fraser and Potter 1969
    joint,  ///< neither: all constraints of all loops at once, of which one loop's two-filter smoother is a
            ///< part
};

/// `forward` and `reverse`: of the same frames. The headings are averaged on the circle.
PassResult fuse(const PassResult& forward, const PassResult& reverse, Weights weights);

}  // namespace loopline::grid_slam
