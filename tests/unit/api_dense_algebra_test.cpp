/// Matrices of any size: what defines each result, for random ones.
#include <gtest/gtest.h>

#include <random>

#include "api/dense_algebra.h"

using namespace loopline;

namespace {

struct RandomMatrices {
    std::mt19937_64 random{7};
    Eigen::MatrixXd any(Eigen::Index rows, Eigen::Index columns) {
        std::normal_distribution<double> normal;
        return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
    }
    Eigen::MatrixXd positive(Eigen::Index size) {
        const Eigen::MatrixXd root = any(size, size);
        return root * root.transpose() + Eigen::MatrixXd::Identity(size, size);
    }
};

}  // namespace

TEST(DenseAlgebra, results_are_what_defines_them) {
    RandomMatrices matrices;
    for (const Eigen::Index n : {1, 2, 3, 6, 17, 24}) {
        const Eigen::MatrixXd A = matrices.positive(n), B = matrices.any(n, 4), R = matrices.any(n, n),
                              I = Eigen::MatrixXd::Identity(n, n);
        EXPECT_TRUE((A * solved(A, B)).isApprox(B, 1e-10)) << n;
        EXPECT_TRUE((R * inverse_of(R)).isApprox(I, 1e-8)) << n;
        const Eigen::VectorXd e = B.col(0), whitened = spectrum_of(A).vectors.transpose() * e;
        EXPECT_NEAR(squared_in_sigmas(e, A), whitened.cwiseAbs2().cwiseQuotient(spectrum_of(A).values).sum(),
                    1e-9 * e.squaredNorm());
        EXPECT_TRUE(propagated(B.transpose(), A).isApprox(B.transpose() * A * B, 1e-12)) << n;
    }
}

TEST(DenseAlgebra, spectra_rise_and_rebuild_the_matrix) {
    RandomMatrices matrices;
    for (const Eigen::Index n : {1, 3, 6, 24}) {
        const Eigen::MatrixXd A = matrices.positive(n), B = matrices.positive(n);
        const Spectrum own = spectrum_of(A), relative = spectrum_relative_to(B, A);
        EXPECT_TRUE(propagated(own.vectors, own.values.asDiagonal().toDenseMatrix()).isApprox(A, 1e-10)) << n;
        EXPECT_TRUE(propagated(relative.vectors.transpose(), B).isIdentity(1e-10)) << n;
        EXPECT_TRUE(
            (A * relative.vectors).isApprox(B * relative.vectors * relative.values.asDiagonal(), 1e-9))
            << n;
        for (Eigen::Index k = 1; k < n; ++k) {
            EXPECT_LE(own.values[k - 1], own.values[k]);
            EXPECT_LE(relative.values[k - 1], relative.values[k]);
        }
    }
}

// A vehicle that stands has a covariance of rank 0 along some directions.
TEST(DenseAlgebra, solves_where_a_covariance_is_singular_but_the_right_side_lies_in_it) {
    const Eigen::Matrix3d A = Eigen::Vector3d(4, 0, 1).asDiagonal();
    const Eigen::Vector3d x = solved(A, Eigen::Vector3d(8, 0, 3));
    EXPECT_NEAR((A * x - Eigen::Vector3d(8, 0, 3)).norm(), 0, 1e-12);
}
