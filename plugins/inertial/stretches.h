/// Sums over stretches of a log of equal length, for the scatter from one to the next, in bounded memory.
#pragma once

#include <cstddef>
#include <vector>

namespace loopline::inertial {

/// `Sums` has `n`, how many values are in it, and `+=`. When there are too many stretches they are joined in
/// pairs, and those to come are twice as long.
template <class Sums>
class Stretches {
 public:
    explicit Stretches(double first_length) : length_(first_length) {}

    /// To add values to; then call close_if_full().
    Sums& open() { return open_; }
    void close_if_full() {
        if (open_.n < length_) return;
        closed_.push_back(open_);
        open_ = {};
        if (closed_.size() == most) join_pairs();
    }

    const std::vector<Sums>& closed() const { return closed_; }
    Sums total() const {
        Sums sum = open_;
        for (const auto& stretch : closed_) sum += stretch;
        return sum;
    }

 private:
    static constexpr std::size_t most = 64;

    void join_pairs() {
        for (std::size_t i = 0; i < most / 2; ++i) {
            closed_[i] = closed_[2 * i];
            closed_[i] += closed_[2 * i + 1];
        }
        closed_.resize(most / 2);
        length_ *= 2;
    }

    double length_;
    std::vector<Sums> closed_;
    Sums open_;
};

}  // namespace loopline::inertial
