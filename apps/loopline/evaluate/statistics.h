/// The figures that trajectory errors are summed up in.
#pragma once

#include <cstddef>
#include <vector>

namespace loopline {

struct Statistics {
    std::size_t count = 0;
    double mean = 0, median = 0, rmse = 0;
    double std_deviation = 0;  ///< of the values as a whole population (divided by their number)
    double max = 0;
};

/// Of values that are not negative; all zero if there are none.
Statistics statistics_of(std::vector<double> values);

}  // namespace loopline
