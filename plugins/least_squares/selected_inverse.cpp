#include "least_squares/selected_inverse.h"

#include <algorithm>
#include <vector>

namespace loopline::least_squares {

// With Z = H^-1 in elimination order and L unit lower triangular, Z = D^-1 L^-1 + (I - L^T) Z gives, from the
// last column to the first, with the sums over the pattern of L's column j:
//     Z(i, j) = - sum_k Z(i, k) L(k, j)   for i > j,        Z(j, j) = 1 / D(j) - sum_k Z(k, j) L(k, j).
// Every Z(i, k) that occurs is itself on the pattern: the rows of a column form a clique of the factor.
Eigen::SparseMatrix<double> selected_inverse(const SparseLdlt& ldlt) {
    // The factor without its unit diagonal, by columns.
    const Eigen::SparseMatrix<double>& L = ldlt.matrixL().nestedExpression();
    const Eigen::VectorXd D = ldlt.vectorD();
    const int n = static_cast<int>(L.cols());
    const int* start = L.outerIndexPtr();
    const int* rows = L.innerIndexPtr();
    const double* values = L.valuePtr();

    std::vector<double> Z(static_cast<std::size_t>(L.nonZeros()));  // beside L's values
    std::vector<double> Z_diagonal(static_cast<std::size_t>(n));
    std::vector<double> column(static_cast<std::size_t>(n), 0.0);  // Z(:, j), scattered
    std::vector<double> factor(static_cast<std::size_t>(n), 0.0);  // L(:, j), scattered
    std::vector<char> marked(static_cast<std::size_t>(n), 0);
    for (int j = n - 1; j >= 0; --j) {
        const int begin = start[j], end = start[j + 1];
        for (int a = begin; a < end; ++a) {
            factor[static_cast<std::size_t>(rows[a])] = values[a];
            column[static_cast<std::size_t>(rows[a])] = 0;
            marked[static_cast<std::size_t>(rows[a])] = 1;
        }
        // Each stored Z(i, k), i > k, serves both (i, k) and (k, i).
        for (int a = begin; a < end; ++a) {
            const auto k = static_cast<std::size_t>(rows[a]);
            const double l_k = factor[k];
            double sum = Z_diagonal[k] * l_k;
            for (int b = start[k]; b < start[k + 1]; ++b) {
                const auto i = static_cast<std::size_t>(rows[b]);
                if (!marked[i]) continue;
                sum += Z[static_cast<std::size_t>(b)] * factor[i];
                column[i] += Z[static_cast<std::size_t>(b)] * l_k;
            }
            column[k] += sum;
        }
        double diagonal = 1 / D(j);
        for (int a = begin; a < end; ++a) {
            const auto i = static_cast<std::size_t>(rows[a]);
            Z[static_cast<std::size_t>(a)] = -column[i];
            diagonal += column[i] * factor[i];
            marked[i] = 0;
        }
        Z_diagonal[static_cast<std::size_t>(j)] = diagonal;
    }

    Eigen::SparseMatrix<double> inverse(n, n);
    inverse.reserve(L.nonZeros() + n);
    for (int j = 0; j < n; ++j) {
        inverse.startVec(j);
        inverse.insertBack(j, j) = Z_diagonal[static_cast<std::size_t>(j)];
        for (int a = start[j]; a < start[j + 1]; ++a)
            inverse.insertBack(rows[a], j) = Z[static_cast<std::size_t>(a)];
    }
    inverse.finalize();
    return inverse;
}

double selected_entry(const Eigen::SparseMatrix<double>& inverse, const SparseLdlt& ldlt, Eigen::Index row,
                      Eigen::Index col) {
    const auto& order = ldlt.permutationP().indices();
    const auto a = order(row), b = order(col);
    return inverse.coeff(std::max(a, b), std::min(a, b));
}

}  // namespace loopline::least_squares
