/// Covariance of a spatial pose. A vehicle on a floor has nine numbers of it that are not zero, and a long
/// trajectory is mostly covariances.
#pragma once

#include <memory>

#include "api/pose3.h"

namespace loopline {

/// Of (x y z roll pitch yaw), in m and rad; zero at first. Its numbers come back as they were given.
class PoseCovariance {
 public:
    PoseCovariance() = default;
    /// A 6x6 matrix is one.
    template <class Derived>
    PoseCovariance(const Eigen::MatrixBase<Derived>& matrix) {
        set(matrix);
    }
    /// Of (x y yaw); the rest is zero.
    static PoseCovariance planar(const Eigen::Matrix3d& matrix);

    double operator()(Eigen::Index row, Eigen::Index column) const;
    Matrix6d matrix() const;
    /// That of (x y yaw).
    Eigen::Matrix3d planar() const;
    /// Whether the rest is zero.
    bool is_planar() const { return spatial_ == nullptr; }
    bool is_finite() const { return spatial_ ? spatial_->allFinite() : planar_.allFinite(); }

 private:
    void set(const Matrix6d& matrix);

    Eigen::Matrix3d planar_ = Eigen::Matrix3d::Zero();
    std::shared_ptr<const Matrix6d> spatial_;  ///< null if the rest is zero
};

}  // namespace loopline
