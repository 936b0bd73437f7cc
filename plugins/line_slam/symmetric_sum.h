/// A sparse symmetric matrix that is summed up from entries at the same places, in the same order, again and
/// again: where each goes is looked up the first time only.
#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

namespace loopline::line_slam {

class SymmetricSum {
 public:
    using Sparse = Eigen::SparseMatrix<double>;

    void begin(Eigen::Index size) {
        size_ = size;
        next_ = 0;
        std::fill(matrix_.valuePtr(), matrix_.valuePtr() + matrix_.nonZeros(), 0.0);
    }

    /// At (a, b) and (b, a).
    void add(Eigen::Index a, Eigen::Index b, double value) {
        if (is_laid_out())
            matrix_.valuePtr()[slots_[next_++]] += value;
        else
            entries_.emplace_back(static_cast<int>(std::max(a, b)), static_cast<int>(std::min(a, b)), value);
    }

    /// The lower triangle.
    const Sparse& finish() {
        if (!is_laid_out()) lay_out();
        return matrix_;
    }

 private:
    bool is_laid_out() const { return !slots_.empty(); }

    void lay_out() {
        matrix_.resize(size_, size_);
        matrix_.setFromTriplets(entries_.begin(), entries_.end());
        slots_.reserve(entries_.size());
        const int *rows = matrix_.innerIndexPtr(), *starts = matrix_.outerIndexPtr();
        for (const auto& e : entries_)
            slots_.push_back(std::lower_bound(rows + starts[e.col()], rows + starts[e.col() + 1], e.row()) -
                             rows);
        entries_ = {};
    }

    Eigen::Index size_ = 0;
    Sparse matrix_;
    std::vector<Eigen::Triplet<double>> entries_;  ///< the first time
    std::vector<std::ptrdiff_t> slots_;            ///< of each entry among the values
    std::size_t next_ = 0;
};

}  // namespace loopline::line_slam
