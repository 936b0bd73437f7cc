#include "api/dense_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace loopline {

Eigen::MatrixXd solved(MatrixIn A, MatrixIn B) {
    return Eigen::LDLT<Eigen::MatrixXd>(A).solve(B);
}

double squared_in_sigmas(VectorIn e, MatrixIn P) {
    return e.dot(solved(P, e).col(0));
}

Eigen::MatrixXd inverse_of(MatrixIn A) {
    return Eigen::PartialPivLU<Eigen::MatrixXd>(A).inverse();
}

Eigen::MatrixXd propagated(MatrixIn F, MatrixIn P) {
    const Eigen::MatrixXd FP = F * P;
    return FP * F.transpose();
}

Spectrum spectrum_of(MatrixIn A) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A);
    return {eigen.eigenvalues(), eigen.eigenvectors()};
}

Spectrum spectrum_relative_to(MatrixIn B, MatrixIn A) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A, B);
    return {eigen.eigenvalues(), eigen.eigenvectors()};
}

}  // namespace loopline
