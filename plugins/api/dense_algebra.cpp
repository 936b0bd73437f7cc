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

Eigen::MatrixXd product(MatrixIn A, MatrixIn B) {
    return A * B;
}

Eigen::MatrixXd propagated(MatrixIn F, MatrixIn P) {
    const Eigen::MatrixXd FP = F * P;
    return FP * F.transpose();
}

Eigen::MatrixXd kalman_gain(MatrixIn P, MatrixIn H, MatrixIn S) {
    const Eigen::MatrixXd HP = H * P;
    return solved(S, HP).transpose();
}

Eigen::MatrixXd updated_covariance(MatrixIn P, MatrixIn K, MatrixIn H, MatrixIn R) {
    // K and H are narrow: what is added costs less than products of I - K H.
    Eigen::MatrixXd after = P;
    after.noalias() -= K * Eigen::MatrixXd(H * P);
    const Eigen::MatrixXd KR_less = K * R - after * H.transpose();
    after.noalias() += KR_less * K.transpose();
    return after;
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
