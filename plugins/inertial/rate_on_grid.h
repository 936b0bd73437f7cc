/// What accumulates (an angle, a way) and is known at odd times, as mean rates in the cells of a fixed grid
/// of time, so that two sensors can be compared cell by cell.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>

#include "api/stamp.h"

namespace loopline::inertial {

struct GridSettings {
    StampNs cell_ns = 20'000'000;
    StampNs longest_gap_ns = 0;  ///< across more nothing is interpolated: the run of cells ends
    std::size_t most_cells = 3000;
};

/// Cell i lasts from i to i + 1 times `cell_ns`. Holds one run of cells without a hole, the latest; the
/// oldest are forgotten. A stamp that goes backwards begins a new run.
template <int n>
class RateOnGrid {
 public:
    using Vector = Eigen::Matrix<double, n, 1>;
    explicit RateOnGrid(const GridSettings& settings) : settings_(settings) {}

    /// `amount` is cumulative: an angle is not wrapped.
    void add(StampNs stamp_ns, const Vector& amount) {
        if (last_ && stamp_ns == last_->stamp_ns) return;
        const bool goes_on =
            last_ && stamp_ns > last_->stamp_ns && stamp_ns - last_->stamp_ns <= settings_.longest_gap_ns;
        if (goes_on)
            pass_boundaries({stamp_ns, amount});
        else
            start_anew();
        last_ = Sample{stamp_ns, amount};
    }

    bool empty() const { return rates_.empty(); }
    std::int64_t first() const { return first_; }
    std::int64_t end() const { return first_ + static_cast<std::int64_t>(rates_.size()); }
    const Vector& rate(std::int64_t cell) const { return rates_[static_cast<std::size_t>(cell - first_)]; }
    void forget_before(std::int64_t cell) {
        while (!rates_.empty() && first_ < cell) {
            rates_.pop_front();
            ++first_;
        }
    }

 private:
    struct Sample {
        StampNs stamp_ns;
        Vector amount;
    };

    void start_anew() {
        rates_.clear();
        boundary_.reset();
    }

    void pass_boundaries(const Sample& now) {
        const double step_s = seconds_between(last_->stamp_ns, now.stamp_ns);
        for (std::int64_t cell = cell_of(last_->stamp_ns) + 1; cell * settings_.cell_ns <= now.stamp_ns;
             ++cell) {
            const double u = seconds_between(last_->stamp_ns, cell * settings_.cell_ns) / step_s;
            const Vector amount = last_->amount + u * (now.amount - last_->amount);
            if (boundary_)
                rates_.push_back((amount - *boundary_) * (1e9 / double(settings_.cell_ns)));
            else
                first_ = cell;
            boundary_ = amount;
        }
        if (rates_.size() > settings_.most_cells)
            forget_before(end() - static_cast<std::int64_t>(settings_.most_cells));
    }

    std::int64_t cell_of(StampNs stamp_ns) const {
        const std::int64_t q = stamp_ns / settings_.cell_ns;
        return q * settings_.cell_ns > stamp_ns ? q - 1 : q;
    }

    GridSettings settings_;
    std::optional<Sample> last_;
    std::optional<Vector> boundary_;  ///< where the next cell begins
    std::int64_t first_ = 0;
    std::deque<Vector> rates_;
};

}  // namespace loopline::inertial
