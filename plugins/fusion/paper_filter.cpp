#include "fusion/paper_filter.h"

#include <algorithm>
#include <cmath>

#include "api/attitude.h"
#include "api/dense_algebra.h"
#include "api/pose2.h"

namespace loopline::fusion {

Vector6d as_numbers(const Pose3& pose) {
    Vector6d s;
    const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
    s << pose.translation_m, std::atan2(R(2, 1), R(2, 2)), -std::asin(std::clamp(R(2, 0), -1.0, 1.0)),
        std::atan2(R(1, 0), R(0, 0));
    return s;
}

Pose3 as_pose(const Vector6d& numbers) {
    return {numbers.head<3>(), attitude(numbers[5], numbers[4], numbers[3])};
}

void PaperFilter::predict(double way_m, double turn_rad, const Matrix6d& R) {
    const double c = std::cos(s_[5]), s = std::sin(s_[5]);
    s_[0] += way_m * c;                    // eq. (4)
    s_[1] += way_m * s;                    // eq. (5)
    s_[5] = wrap_to_pi(s_[5] + turn_rad);  // eq. (6)
    Matrix6d F = Matrix6d::Identity();     // derivative by the angle about z
    F(0, 5) = -way_m * s;
    F(1, 5) = way_m * c;
    P_ = propagated(F, P_) + R;
}

void PaperFilter::observe(const Pose3& told, std::initializer_list<int> which, const Vector6d& sigma) {
    const Vector6d w = as_numbers(told);
    const auto rows = static_cast<Eigen::Index>(which.size());
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(rows, 6), Q = Eigen::MatrixXd::Zero(rows, rows);
    Eigen::VectorXd off(rows);
    Eigen::Index row = 0;
    for (const int k : which) {
        C(row, k) = 1;
        Q(row, row) = sigma[k] * sigma[k];
        off[row] = k < 3 ? w[k] - s_[k] : wrap_to_pi(w[k] - s_[k]);
        ++row;
    }
    const Eigen::MatrixXd S = propagated(C, P_) + Q;
    const Eigen::MatrixXd K = solved(S, C * P_).transpose();  // K = P C' S^-1
    s_ += K * off;
    for (int k = 3; k < 6; ++k) s_[k] = wrap_to_pi(s_[k]);
    P_ = (Matrix6d::Identity() - K * C) * P_;
    P_ = (P_ + P_.transpose()).eval() / 2;
}

void PaperFilter::follow(const Pose3& T_before_now, const Vector6d& sigma) {
    s_ = as_numbers(pose() * T_before_now);
    P_ += Matrix6d(sigma.cwiseAbs2().asDiagonal());
}

}  // namespace loopline::fusion
