#include "lidar_mapping/lasting_error.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace loopline::lidar_mapping {

Matrix6d of_coming_back(const Registration& found, const Matrix6d& before) {
    const Eigen::Matrix<double, 6, 1> back = before * found.predicted.ldlt().solve(found.correction);
    return back * back.transpose();
}

Matrix6d what_lasts(const Registration& found) {
    // Where the surroundings hold a sweep better than this, it is not by chance.
    constexpr double well_held_m = 0.004;
    Eigen::Matrix<double, 6, 1> lever;  // a turn counts by what it moves
    lever << 1, 1, 1, Eigen::Vector3d::Constant(found.mean_range_m);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(lever.asDiagonal() * found.by_scan *
                                                        lever.asDiagonal());
    const double renewed = 1 / std::max(1.0, found.age_sweeps);
    Eigen::Matrix<double, 6, 1> lasting_m2 = eigen.eigenvalues().cwiseMax(0);
    for (double& m2 : lasting_m2) {
        const double doubt = std::pow(m2 / (well_held_m * well_held_m), 2);
        m2 *= renewed + (1 - renewed) * doubt / (1 + doubt);
    }
    const Matrix6d directions = lever.cwiseInverse().asDiagonal() * eigen.eigenvectors();
    return directions * lasting_m2.asDiagonal() * directions.transpose();
}

}  // namespace loopline::lidar_mapping
