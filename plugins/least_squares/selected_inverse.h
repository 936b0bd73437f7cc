/// Entries of the inverse of a sparse matrix on the pattern of its Cholesky factor: all the covariances of
/// single poses and lines at about the cost of one more factorisation. Takahashi, Fagan and Chin 1973.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace loopline::least_squares {

using SparseLdlt = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

/// Lower triangle, in the factor's elimination order, of H^-1 on the pattern of L, with H = P^T L D L^T P.
Eigen::SparseMatrix<double> selected_inverse(const SparseLdlt& ldlt);

/// Entry (row, col), in H's own order, of the result; the pair must be in the pattern, as every non-zero of H
/// is.
double selected_entry(const Eigen::SparseMatrix<double>& inverse, const SparseLdlt& ldlt, Eigen::Index row,
                      Eigen::Index col);

}  // namespace loopline::least_squares
