/// Which directions of motion the scene holds, and which it leaves free. Zhang, Kaess, Singh 2016, "On
/// degeneracy of optimization-based state estimation problems": eigenvectors of the information whose
/// eigenvalue is small are left out of the solution.
#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>

#include "lidar_odometry/scan_to_scan.h"

namespace loopline::lidar_odometry {

class HeldDirections {
 public:
    /// `information` on (shift, turn); a turn counts by what it moves at `range_m`.
    HeldDirections(const Matrix6d& information, double range_m, double sigma_limit_m)
        : least_(1 / (sigma_limit_m * sigma_limit_m)) {
        scale_ << 1, 1, 1, 1 / range_m, 1 / range_m, 1 / range_m;
        eigen_.compute(scale_.asDiagonal() * information * scale_.asDiagonal());
    }

    bool all() const { return !(eigen_.eigenvalues()[0] < least_); }
    /// Onto what is held.
    Matrix6d projection() const {
        return scale_.asDiagonal() * eigen_.eigenvectors() * held().asDiagonal() *
               eigen_.eigenvectors().transpose() * scale_.cwiseInverse().asDiagonal();
    }
    /// Without that on the free directions.
    Matrix6d information() const {
        const Matrix6d axes = scale_.cwiseInverse().asDiagonal() * eigen_.eigenvectors();
        return axes * held().cwiseProduct(eigen_.eigenvalues()).asDiagonal() * axes.transpose();
    }
    FreeDirections free() const {
        FreeDirections result;
        result.count = static_cast<int>((eigen_.eigenvalues().array() < least_).count());
        result.weakest_sigma_m = 1 / std::sqrt(std::max(eigen_.eigenvalues()[0], 1e-6));
        result.weakest_moves_m = eigen_.eigenvectors().col(0);
        result.weakest = (scale_.asDiagonal() * result.weakest_moves_m).normalized();
        return result;
    }

 private:
    /// 1 for a direction that is held, else 0.
    Vector6d held() const {
        return (eigen_.eigenvalues().array() < least_).select(Vector6d::Zero(), Vector6d::Ones());
    }

    double least_;
    Vector6d scale_;
    Eigen::SelfAdjointEigenSolver<Matrix6d> eigen_;
};

}  // namespace loopline::lidar_odometry
