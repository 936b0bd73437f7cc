#include "lidar_mapping/shared_errors.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace loopline::lidar_mapping {
namespace {

constexpr double first_ring_m = 8;  // each is twice as far

}  // namespace

void SharedErrors::add(const Eigen::Vector3d& arm_m, const Eigen::Matrix<double, 6, 1>& gradient, double s) {
    const double turns = std::atan2(arm_m.y(), arm_m.x()) / (2 * M_PI) + 0.5;
    const auto sector = std::min(static_cast<std::size_t>(turns * sectors), sectors - 1);
    std::size_t ring = 0;
    for (double end_m = first_ring_m; ring + 1 < rings && arm_m.norm() >= end_m; end_m *= 2) ++ring;
    Vector12d both;
    both << gradient, s * gradient;
    clusters_[sector * rings + ring] += both;
}

/// With V such that V' alone V = I and V' S V = diag(lambda), S the sum over clusters of g g'.
Matrix12d SharedErrors::covariance(const Matrix12d& alone) const {
    // The largest eigenvalue of so few clusters that err by chance (Marchenko and Pastur 1967).
    static const double by_chance = std::pow(1 + std::sqrt(12.0 / (sectors * rings)), 2);
    Matrix12d together = Matrix12d::Zero();
    for (const Vector12d& g : clusters_) together += g * g.transpose();
    const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix12d> eigen(together, alone);
    if (!(eigen.eigenvalues()[11] > by_chance)) return alone;
    const Vector12d lambda = (eigen.eigenvalues().array() + (1 - by_chance)).cwiseMax(1.0);
    const Matrix12d half = alone * eigen.eigenvectors();
    return half * lambda.asDiagonal() * half.transpose();
}

}  // namespace loopline::lidar_mapping
