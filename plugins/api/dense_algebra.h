/// What costs a compiler seconds for each size of matrix, compiled once for all sizes. Matrices of fixed size
/// go in as they are, and a result fits into one. A call takes 0.1 to 0.6 us more than Eigen's own of a fixed
/// size up to 6 x 6, and up to a third more from 12 x 12 on: not for what is done for every point of a scan.
#pragma once

#include <Eigen/Core>

namespace loopline {

using MatrixIn = const Eigen::Ref<const Eigen::MatrixXd>&;
using VectorIn = const Eigen::Ref<const Eigen::VectorXd>&;

/// A^-1 B of a symmetric A that is not negative.
Eigen::MatrixXd solved(MatrixIn A, MatrixIn B);
/// e' P^-1 e: the square of Mahalanobis' distance; chi-square if P is the covariance of e.
double squared_in_sigmas(VectorIn e, MatrixIn P);
/// A^-1 of a regular A.
Eigen::MatrixXd inverse_of(MatrixIn A);
/// A B.
Eigen::MatrixXd product(MatrixIn A, MatrixIn B);
/// F P F': the covariance of F e, P that of e.
Eigen::MatrixXd propagated(MatrixIn F, MatrixIn P);
/// Kalman's K = P H' S^-1, S the covariance of the innovation.
Eigen::MatrixXd kalman_gain(MatrixIn P, MatrixIn H, MatrixIn S);
/// (I - K H) P (I - K H)' + K R K': what a measurement of noise R leaves of P, by Joseph's form, which is
/// symmetric and positive whatever the rounding.
Eigen::MatrixXd updated_covariance(MatrixIn P, MatrixIn K, MatrixIn H, MatrixIn R);

/// Of a symmetric matrix: eigenvalues from the least one on, and eigenvectors of length 1 as columns.
struct Spectrum {
    Eigen::VectorXd values;
    Eigen::MatrixXd vectors;
};
Spectrum spectrum_of(MatrixIn A);
/// The same relative to a positive B: A V = B V diag(values), V' B V = I.
Spectrum spectrum_relative_to(MatrixIn B, MatrixIn A);

}  // namespace loopline
