/// Systems of 3 x 3 blocks against dense algebra.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "least_squares/block_ldlt.h"

using namespace loopline::least_squares;

namespace {

/// A random positive definite H with a few blocks beside its diagonal, dense and in blocks.
struct BlockSystem {
    std::vector<BlockLdlt::Pair> pairs;
    std::vector<Eigen::Matrix3d> parts;
    Eigen::MatrixXd H;

    BlockSystem(std::uint32_t blocks, std::size_t count, std::mt19937_64& random)
        : H(10.0 * Eigen::MatrixXd::Identity(3 * blocks, 3 * blocks)) {
        std::uniform_real_distribution<double> uniform(-1, 1);
        while (pairs.size() < count) {
            const auto a = static_cast<std::uint32_t>(random() % blocks),
                       b = static_cast<std::uint32_t>(random() % blocks);
            if (a == b) continue;
            pairs.emplace_back(a, b);  // now and then twice, or the other way round
            parts.push_back(Eigen::Matrix3d::NullaryExpr([&] { return uniform(random); }));
            H.block<3, 3>(3 * a, 3 * b) += parts.back();
            H.block<3, 3>(3 * b, 3 * a) += parts.back().transpose();
        }
    }
    void put_into(BlockLdlt& ldlt) const {
        ldlt.set_zero();
        for (std::size_t k = 0; k < pairs.size(); ++k) ldlt.add(k, parts[k]);
        for (std::uint32_t k = 0; 3 * k < H.rows(); ++k) ldlt.add_diagonal(k, H.block<3, 3>(3 * k, 3 * k));
    }
};

TEST(BlockLdlt, solution_and_inverse_equal_those_of_dense_algebra) {
    std::mt19937_64 random(1);
    for (const std::uint32_t blocks : {1U, 2U, 7U, 40U, 90U})
        for (int run = 0; run < 20; ++run) {
            const BlockSystem system(blocks, blocks > 1 ? 2 * blocks : 0, random);
            BlockLdlt ldlt(blocks, system.pairs);
            for (int again = 0; again < 2; ++again) {  // the second time in the same memory
                system.put_into(ldlt);
                ASSERT_TRUE(ldlt.factorise());
            }
            const Eigen::VectorXd b = Eigen::VectorXd::Random(3 * blocks);
            EXPECT_LT((system.H * ldlt.solve(b) - b).cwiseAbs().maxCoeff(), 1e-12);
            const Eigen::MatrixXd inverse = system.H.inverse();
            const auto diagonal = ldlt.inverse_diagonal();
            for (std::uint32_t k = 0; k < blocks; ++k)
                EXPECT_LT((diagonal[k] - inverse.block<3, 3>(3 * k, 3 * k)).cwiseAbs().maxCoeff(), 1e-12);
        }
}

TEST(BlockLdlt, says_when_a_system_is_not_positive_definite) {
    std::mt19937_64 random(2);
    const BlockSystem system(12, 20, random);
    for (std::uint32_t wrong = 0; wrong < 12; ++wrong)
        for (int axis = 0; axis < 3; ++axis) {
            BlockLdlt ldlt(12, system.pairs);
            system.put_into(ldlt);
            Eigen::Matrix3d less = Eigen::Matrix3d::Zero();
            less(axis, axis) = -2 * system.H(3 * wrong + axis, 3 * wrong + axis);
            ldlt.add_diagonal(wrong, less);
            EXPECT_FALSE(ldlt.factorise());
        }
}

}  // namespace
