#include "inertial/planar_information.h"

#include <Eigen/Eigenvalues>

namespace loopline::inertial {

KnownDirections known_directions(const PlanarInformation& pose, double vaguest_sigma) {
    // The matrix of a real matcher is symmetric and positive but for rounding.
    constexpr double rounding = 1e-12;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
        (pose.information + pose.information.transpose()) / 2);
    const Eigen::Vector3d& lambda = eigen.eigenvalues();
    const double least = std::max(1 / (vaguest_sigma * vaguest_sigma), rounding * lambda.maxCoeff());
    KnownDirections known;
    for (int i = 0; i < 3; ++i) {
        if (!(lambda(i) > least)) continue;
        const Eigen::Vector3d v = eigen.eigenvectors().col(i);
        known.at[known.count++] = {v, v.dot(pose.gradient) / lambda(i), 1 / lambda(i)};
    }
    return known;
}

}  // namespace loopline::inertial
