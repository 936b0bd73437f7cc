#include "simulation/gnss_sky.h"

#include <algorithm>

namespace loopline::simulation {

using gnss::FixQuality;

namespace {

bool within(double value, double from, double to) {
    return value >= std::min(from, to) && value <= std::max(from, to);
}

bool is_known(double code) {
    return code == 0 || code == 1 || code == 4 || code == 5;
}

}  // namespace

FixQuality GnssSky::at(double time_s, double way_m, const Eigen::Vector2d& place_m) const {
    FixQuality quality = elsewhere;
    for (const auto& row : by_way)
        if (within(way_m, row[0], row[1])) quality = gnss::fix_quality(static_cast<int>(row[2]));
    for (const auto& row : by_zone)
        if (within(place_m.x(), row[0], row[2]) && within(place_m.y(), row[1], row[3]))
            quality = gnss::fix_quality(static_cast<int>(row[4]));
    for (const auto& row : by_time)
        if (within(time_s, row[0], row[1])) quality = gnss::fix_quality(static_cast<int>(row[2]));
    return quality;
}

std::string GnssSky::check() const {
    for (const auto* rows : {&by_way, &by_zone, &by_time})
        for (const auto& row : *rows)
            if (!is_known(row.back()))
                return "has a row whose last number is none of 0 (no fix), 1 (single), 4 (fixed) and 5 "
                       "(float)";
    return {};
}

}  // namespace loopline::simulation
