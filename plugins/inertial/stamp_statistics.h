/// Steps between the stamps of a sensor, in a fixed number of bins.
#pragma once

#include <array>
#include <cstdint>

#include "api/stamp.h"

namespace loopline::inertial {

class StampStatistics {
 public:
    void add(StampNs stamp_ns);

    std::uint64_t count() const { return count_; }
    std::uint64_t repeated() const { return repeated_; }
    std::uint64_t backwards() const { return backwards_; }
    StampNs worst_backwards_ns() const { return worst_backwards_ns_; }
    /// Of the steps forward, to 1 % or better; 0 if there is none.
    double median_step_s() const;
    /// Steps longer than `factor` medians.
    std::uint64_t gaps(double factor) const;
    double longest_step_s() const { return static_cast<double>(longest_step_ns_) * 1e-9; }
    StampNs longest_step_start_ns() const { return longest_step_start_ns_; }

 private:
    // From 0.01 ms in factors of 1.02, to 4600 s.
    static constexpr std::size_t bins = 1008;
    static std::size_t bin_of(double step_s);

    std::array<std::uint64_t, bins> steps_{};
    std::array<double, bins> lengths_s_{};  ///< of the steps in each bin, together
    std::uint64_t count_ = 0, forward_ = 0, repeated_ = 0, backwards_ = 0;
    StampNs last_ns_ = 0, worst_backwards_ns_ = 0, longest_step_ns_ = 0, longest_step_start_ns_ = 0;
};

}  // namespace loopline::inertial
