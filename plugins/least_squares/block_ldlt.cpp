#include "least_squares/block_ldlt.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

namespace loopline::least_squares {
namespace {

auto part(Eigen::VectorXd& v, std::size_t block) {
    return v.segment<3>(static_cast<Eigen::Index>(3 * block));
}

/// By its leading minors.
bool is_positive_definite(const Eigen::Matrix3d& m) {
    const double det2 = m(0, 0) * m(1, 1) - m(1, 0) * m(1, 0);
    return m(0, 0) > 0 && det2 > 0 && m.determinant() > 0;
}

}  // namespace

BlockLdlt::BlockLdlt(std::size_t blocks, const std::vector<Pair>& pairs) {
    choose_order(blocks, pairs);
    lay_out(pairs);
    lay_out_factor();
}

void BlockLdlt::choose_order(std::size_t blocks, const std::vector<Pair>& pairs) {
    std::vector<Eigen::Triplet<char>> entries;
    entries.reserve(2 * pairs.size() + blocks);
    for (std::size_t k = 0; k < blocks; ++k)
        entries.emplace_back(static_cast<int>(k), static_cast<int>(k), 1);
    for (const auto& [a, b] : pairs) {
        entries.emplace_back(static_cast<int>(a), static_cast<int>(b), 1);
        entries.emplace_back(static_cast<int>(b), static_cast<int>(a), 1);
    }
    Eigen::SparseMatrix<char> pattern(static_cast<Eigen::Index>(blocks), static_cast<Eigen::Index>(blocks));
    pattern.setFromTriplets(entries.begin(), entries.end(), [](char a, char) { return a; });
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::internal::minimum_degree_ordering(pattern, order);
    place_of_.resize(blocks);
    for (std::size_t place = 0; place < blocks; ++place)
        place_of_[static_cast<std::size_t>(order.indices()(static_cast<Eigen::Index>(place)))] =
            static_cast<std::uint32_t>(place);
}

void BlockLdlt::lay_out(const std::vector<Pair>& pairs) {
    const auto above = [this](const Pair& pair) {
        return std::minmax(place_of_[pair.first], place_of_[pair.second]);
    };
    std::vector<std::vector<std::uint32_t>> rows(size());  // of each column
    for (const Pair& pair : pairs) {
        const auto [row, column] = above(pair);
        rows[column].push_back(row);
    }
    upper_begin_.assign(1, 0);
    upper_row_.clear();
    for (auto& of_column : rows) {
        std::sort(of_column.begin(), of_column.end());
        of_column.erase(std::unique(of_column.begin(), of_column.end()), of_column.end());
        upper_row_.insert(upper_row_.end(), of_column.begin(), of_column.end());
        upper_begin_.push_back(static_cast<std::uint32_t>(upper_row_.size()));
    }
    place_of_pair_.reserve(pairs.size());
    for (const Pair& pair : pairs) {
        const auto [row, column] = above(pair);
        const auto begin = upper_row_.begin() + upper_begin_[column],
                   end = upper_row_.begin() + upper_begin_[column + 1];
        place_of_pair_.push_back(
            {static_cast<std::uint32_t>(std::lower_bound(begin, end, row) - upper_row_.begin()),
             place_of_[pair.first] == column});
    }
    diagonal_.resize(size());
    upper_.resize(upper_row_.size());
    set_zero();
}

/// The elimination tree, and how many blocks each column of L has.
void BlockLdlt::lay_out_factor() {
    parent_.assign(size(), -1);
    std::vector<std::uint32_t> count(size(), 0), seen_by(size());
    for (std::uint32_t k = 0; k < size(); ++k) {
        seen_by[k] = k;
        for (std::uint32_t a = upper_begin_[k]; a < upper_begin_[k + 1]; ++a)
            for (std::uint32_t i = upper_row_[a]; seen_by[i] != k;
                 i = static_cast<std::uint32_t>(parent_[i])) {
                if (parent_[i] < 0) parent_[i] = static_cast<std::int32_t>(k);
                ++count[i];
                seen_by[i] = k;
            }
    }
    begin_.assign(size() + 1, 0);
    std::partial_sum(count.begin(), count.end(), begin_.begin() + 1);
    row_.resize(begin_.back());
    L_.resize(begin_.back());
    D_inverse_.resize(size());
}

void BlockLdlt::set_zero() {
    std::fill(diagonal_.begin(), diagonal_.end(), Block::Zero());
    std::fill(upper_.begin(), upper_.end(), Block::Zero());
}

// Row k of L: y = D L(k, :)' solves the triangle of the rows before it, L y = H(:, k); it has blocks where
// the elimination tree leads from those of H(:, k) up to k.
bool BlockLdlt::factorise() {
    const auto n = static_cast<std::uint32_t>(size());
    std::vector<Block> y(n, Block::Zero());
    std::vector<std::uint32_t> end(begin_.begin(), begin_.end() - 1), seen_by(n), path, reach(n);
    for (std::uint32_t k = 0; k < n; ++k) {
        // In topological order at the end of `reach`.
        std::uint32_t top = n;
        seen_by[k] = k;
        for (std::uint32_t a = upper_begin_[k]; a < upper_begin_[k + 1]; ++a) {
            y[upper_row_[a]] = upper_[a];
            path.clear();
            for (std::uint32_t i = upper_row_[a]; seen_by[i] != k;
                 i = static_cast<std::uint32_t>(parent_[i])) {
                path.push_back(i);
                seen_by[i] = k;
            }
            for (auto i = path.rbegin(); i != path.rend(); ++i) reach[--top] = *i;
        }
        Block D = diagonal_[k];
        for (; top < n; ++top) {
            const std::uint32_t i = reach[top];
            const Block y_i = y[i];
            y[i].setZero();
            for (std::uint32_t b = begin_[i]; b < end[i]; ++b) y[row_[b]].noalias() -= L_[b] * y_i;
            const Block l_ki = (D_inverse_[i] * y_i).transpose();
            D.noalias() -= l_ki * y_i;
            row_[end[i]] = k;
            L_[end[i]++] = l_ki;
        }
        if (!is_positive_definite(D)) return false;
        D_inverse_[k] = D.inverse();
    }
    return true;
}

Eigen::VectorXd BlockLdlt::solve(const Eigen::VectorXd& b) const {
    Eigen::VectorXd x(b.size());
    for (std::size_t k = 0; k < size(); ++k)
        part(x, place_of_[k]) = b.segment<3>(static_cast<Eigen::Index>(3 * k));
    for (std::size_t j = 0; j < size(); ++j) {
        const Eigen::Vector3d x_j = part(x, j);
        for (std::uint32_t a = begin_[j]; a < begin_[j + 1]; ++a) part(x, row_[a]) -= L_[a] * x_j;
    }
    for (std::size_t j = size(); j-- > 0;) {
        Eigen::Vector3d x_j = D_inverse_[j] * part(x, j);
        for (std::uint32_t a = begin_[j]; a < begin_[j + 1]; ++a) x_j -= L_[a].transpose() * part(x, row_[a]);
        part(x, j) = x_j;
    }
    Eigen::VectorXd result(b.size());
    for (std::size_t k = 0; k < size(); ++k) part(result, k) = part(x, place_of_[k]);
    return result;
}

// With Z = H^-1, Z = D^-1 L^-1 + (I - L') Z gives, from the last column to the first, with sums over the
// pattern of L's column j:
//     Z(i, j) = - sum_k Z(i, k) L(k, j)   for i > j,        Z(j, j) = D(j)^-1 - sum_k L(k, j)' Z(k, j).
// Every Z(i, k) that occurs is itself on the pattern: the rows of a column form a clique of the factor.
// Column j of L is not needed after that of Z, which takes its place.
std::vector<BlockLdlt::Block> BlockLdlt::inverse_diagonal() {
    std::vector<Block>& Z = L_;
    std::vector<Block> Z_diagonal(size()), column(size(), Block::Zero());
    std::vector<const Block*> factor(size(), nullptr);  // L(:, j), scattered
    for (std::size_t j = size(); j-- > 0;) {
        for (std::uint32_t a = begin_[j]; a < begin_[j + 1]; ++a) {
            factor[row_[a]] = &L_[a];
            column[row_[a]].setZero();
        }
        for (std::uint32_t a = begin_[j]; a < begin_[j + 1]; ++a) {
            const std::uint32_t k = row_[a];
            column[k].noalias() += Z_diagonal[k] * L_[a];
            // Each stored Z(i, k), i > k, serves both (i, k) and (k, i).
            for (std::uint32_t b = begin_[k]; b < begin_[k + 1]; ++b) {
                const std::uint32_t i = row_[b];
                if (factor[i] == nullptr) continue;
                column[i].noalias() += Z[b] * L_[a];
                column[k].noalias() += Z[b].transpose() * *factor[i];
            }
        }
        Z_diagonal[j] = D_inverse_[j];
        for (std::uint32_t a = begin_[j]; a < begin_[j + 1]; ++a) {
            Z_diagonal[j].noalias() += L_[a].transpose() * column[row_[a]];
            Z[a] = -column[row_[a]];
            factor[row_[a]] = nullptr;
        }
    }
    std::vector<Block> result(size());
    for (std::size_t k = 0; k < size(); ++k) result[k] = Z_diagonal[place_of_[k]];
    return result;
}

}  // namespace loopline::least_squares
