/// One channel of a sensor: its mean, and the longest time for which it did not change by a digit.
#pragma once

#include <cstdint>

#include "api/stamp.h"

namespace loopline::inertial {

class ChannelStatistics {
 public:
    void add(StampNs stamp_ns, double value) {
        if (count_ == 0 || value != value_) {
            value_ = value;
            start_ns_ = stamp_ns;
            run_ = 0;
        }
        ++count_;
        ++run_;
        if (run_ > longest_.readings) longest_ = {run_, start_ns_, stamp_ns, value_};
    }

    /// Readings in a row with the same value.
    struct Run {
        std::uint64_t readings = 0;
        StampNs first_ns = 0, last_ns = 0;
        double value = 0;
    };
    const Run& longest_run() const { return longest_; }
    bool never_changed() const { return longest_.readings == count_; }

 private:
    std::uint64_t count_ = 0, run_ = 0;
    double value_ = 0;
    StampNs start_ns_ = 0;
    Run longest_;
};

}  // namespace loopline::inertial
