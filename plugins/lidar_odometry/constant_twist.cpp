#include "lidar_odometry/constant_twist.h"

#include "api/dense_algebra.h"
#include "inertial/rotation_vector.h"

namespace loopline::lidar_odometry {
namespace {

/// [twist, .] of the Lie algebra, on (shift, turn).
Matrix6d adjoint(const Twist3& twist) {
    Matrix6d ad = Matrix6d::Zero();
    ad.topLeftCorner<3, 3>() = ad.bottomRightCorner<3, 3>() = inertial::cross_matrix(twist.turn_rad);
    ad.topRightCorner<3, 3>() = inertial::cross_matrix(twist.shift_m);
    return ad;
}

}  // namespace

Matrix6d left_jacobian_se3(const Twist3& twist) {
    const Matrix6d ad = adjoint(twist);
    Matrix6d sum = Matrix6d::Identity(), term = Matrix6d::Identity();
    for (int k = 1; k < 20; ++k) {
        term = term * ad / (k + 1);
        sum += term;
    }
    return sum;
}

ConstantTwist::ConstantTwist(const Pose3& T_before_now, double duration_s)
    : twist_(log_se3(T_before_now)), duration_s_(duration_s) {
    const Matrix6d ad = adjoint(twist_), J = left_jacobian_se3(twist_);
    series_[0] = inverse_of(J);
    for (std::size_t k = 1; k < terms; ++k) series_[k] = ad * series_[k - 1] / static_cast<double>(k + 1);
}

Row6d ConstantTwist::derivative(const Eigen::Vector3d& n, const Eigen::Vector3d& p_before_m,
                                double time_s) const {
    Row6d row;
    row << n.transpose(), p_before_m.cross(n).transpose();
    const double u = part(time_s);
    Row6d sum = u * (row * series_[terms - 1]);
    for (std::size_t k = terms - 1; k-- > 0;) sum = u * (row * series_[k] + sum);
    return sum;
}

}  // namespace loopline::lidar_odometry
