/// What a receiver can do where and when: which kind of fix it has.
#pragma once

#include <string>
#include <vector>

#include "gnss/gnss_fix.h"

namespace loopline::simulation {

/// Rows of an .ini, each with the code of a fix, as GGA has it, in the end: 0 none, 1 single, 4 fixed, 5
/// float.
struct GnssSky {
    gnss::FixQuality elsewhere = gnss::FixQuality::rtk_fixed;
    std::vector<std::vector<double>> by_way;   ///< from to code: metres of the way since the start
    std::vector<std::vector<double>> by_zone;  ///< x1 y1 x2 y2 code: a rectangle of the map
    std::vector<std::vector<double>> by_time;  ///< from to code: seconds since the start
    double refix_s = 5;                        ///< after a time without fixes, so long no better than float

    /// The last row that applies decides; times go before zones, and zones before ways.
    gnss::FixQuality at(double time_s, double way_m, const Eigen::Vector2d& place_m) const;
    /// What is wrong with the rows, as a clause; empty if nothing is.
    std::string check() const;
};

}  // namespace loopline::simulation
