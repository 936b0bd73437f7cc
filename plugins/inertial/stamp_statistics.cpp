#include "inertial/stamp_statistics.h"

#include <algorithm>
#include <cmath>

namespace loopline::inertial {
namespace {
constexpr double shortest_s = 1e-5, factor_of_bin = 1.02;
}

std::size_t StampStatistics::bin_of(double step_s) {
    const double bin = std::log(step_s / shortest_s) / std::log(factor_of_bin);
    return static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(bins - 1)));
}

void StampStatistics::add(StampNs stamp_ns) {
    const StampNs step_ns = stamp_ns - last_ns_;
    if (count_++ > 0) {
        if (step_ns > 0) {
            const double step_s = static_cast<double>(step_ns) * 1e-9;
            ++forward_;
            ++steps_[bin_of(step_s)];
            lengths_s_[bin_of(step_s)] += step_s;
            if (step_ns > longest_step_ns_) {
                longest_step_ns_ = step_ns;
                longest_step_start_ns_ = last_ns_;
            }
        } else if (step_ns == 0) {
            ++repeated_;
        } else {
            ++backwards_;
            worst_backwards_ns_ = std::max(worst_backwards_ns_, -step_ns);
        }
    }
    last_ns_ = stamp_ns;
}

double StampStatistics::median_step_s() const {
    std::uint64_t below = 0;
    for (std::size_t bin = 0; bin < bins; ++bin) {
        below += steps_[bin];
        if (steps_[bin] > 0 && 2 * below >= forward_)
            return lengths_s_[bin] / static_cast<double>(steps_[bin]);
    }
    return 0;
}

std::uint64_t StampStatistics::gaps(double factor) const {
    const double limit_s = factor * median_step_s();
    std::uint64_t found = 0;
    for (std::size_t bin = bin_of(limit_s) + 1; bin < bins; ++bin) found += steps_[bin];
    return found;
}

}  // namespace loopline::inertial
