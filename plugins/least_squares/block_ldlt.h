/// Sparse symmetric positive definite systems whose unknowns come in threes, as poses in the plane do: H =
/// L D L' by blocks of 3 x 3. The indices of a sparse factor then cost a ninth of what they do entry by
/// entry. (Up-looking factorisation: Davis, Direct Methods for Sparse Linear Systems, 2006, chapter 4.)
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

namespace loopline::least_squares {

class BlockLdlt {
 public:
    using Block = Eigen::Matrix3d;
    using Pair = std::pair<std::uint32_t, std::uint32_t>;

    /// `pairs`: unknowns (both < blocks, and different) between which H may have blocks; a pair may come
    /// twice. Chooses an order of elimination for them (approximate minimum degree).
    BlockLdlt(std::size_t blocks, const std::vector<Pair>& pairs);

    // H is zero at first.
    void set_zero();
    void add_diagonal(std::uint32_t block, const Block& part) { diagonal_[place_of_[block]] += part; }
    /// To H(first, second) of pair number `pair`, and its transpose to H(second, first).
    void add(std::size_t pair, const Block& part) {
        const Place& place = place_of_pair_[pair];
        if (place.transposed)
            upper_[place.at] += part.transpose();
        else
            upper_[place.at] += part;
    }

    /// False if H is not positive definite.
    bool factorise();
    /// H x = b, after factorise().
    Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
    /// The 3 x 3 blocks on the diagonal of H^-1, after factorise(): the inverse on the pattern of L
    /// (Takahashi, Fagan and Chin 1973). It takes the place of the factor, which has to be made again.
    std::vector<Block> inverse_diagonal();

 private:
    struct Place {
        std::uint32_t at;
        bool transposed;
    };
    void choose_order(std::size_t blocks, const std::vector<Pair>& pairs);
    void lay_out(const std::vector<Pair>& pairs);
    void lay_out_factor();

    std::size_t size() const { return place_of_.size(); }

    std::vector<std::uint32_t> place_of_;  ///< of an unknown in the order of elimination
    std::vector<Place> place_of_pair_;
    // H in that order: blocks on the diagonal, and those above it by columns.
    std::vector<Block> diagonal_, upper_;
    std::vector<std::uint32_t> upper_begin_, upper_row_;
    // L by columns, without its unit diagonal; D as its inverse.
    std::vector<std::int32_t> parent_;  ///< in the elimination tree; -1 for a root
    std::vector<std::uint32_t> begin_, row_;
    std::vector<Block> L_, D_inverse_;
};

}  // namespace loopline::least_squares
