#include "landmark_odometry/landmark_filter.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "api/dense_algebra.h"

namespace loopline::landmark_odometry {
namespace {

Eigen::Matrix2d rotation(double phi_rad) {
    const double c = std::cos(phi_rad), s = std::sin(phi_rad);
    return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

/// Derivative of a place by a turn about the origin.
Eigen::Vector2d turned_left(const Eigen::Vector2d& p_m) {
    return {-p_m.y(), p_m.x()};
}

}  // namespace

double Innovation::square() const {
    return off_m.dot(covariance_m2.llt().solve(off_m));
}

void LandmarkFilter::move(const Twist2& told, const MotionNoise& noise) {
    const Pose2 before = T_local_base(), after = before * exp_se2(told);
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    F.topRightCorner<2, 1>() = turned_left(after.translation() - before.translation());
    const Eigen::Index n = state_.size();
    covariance_.topRows<3>() = (F * covariance_.topRows<3>()).eval();
    covariance_.leftCols<3>() = (covariance_.leftCols<3>() * F.transpose()).eval();

    const double way_m = std::hypot(told.forward_m, told.left_m),
                 turns = std::abs(told.turn_rad) / (2 * M_PI);
    Eigen::Matrix3d G = Eigen::Matrix3d::Identity();
    G.topLeftCorner<2, 2>() = rotation(before.phi_rad + told.turn_rad / 2);
    G.topRightCorner<2, 1>() = F.topRightCorner<2, 1>() / 2;  // made on the way, on average half of it before
    const Eigen::Vector3d variances(noise.along_m * noise.along_m * way_m,
                                    noise.across_m * noise.across_m * way_m,
                                    noise.heading_rad * noise.heading_rad * way_m +
                                        noise.heading_per_turn_rad * noise.heading_per_turn_rad * turns);
    covariance_.topLeftCorner<3, 3>() += G * variances.asDiagonal() * G.transpose();
    state_.head<3>() << after.x_m, after.y_m, after.phi_rad;
    if (n > 3) covariance_.bottomLeftCorner(n - 3, 3) = covariance_.topRightCorner(3, n - 3).transpose();
}

Innovation LandmarkFilter::innovation(std::size_t landmark, const Sighting& sighting) const {
    const Eigen::Index m = at(landmark);
    const Eigen::Matrix2d R_base_local = rotation(state_[2]).transpose();
    const Eigen::Vector2d p_base_m = R_base_local * (state_.segment<2>(m) - state_.head<2>());
    Innovation innovation;
    innovation.off_m = sighting.p_base_m - p_base_m;
    innovation.by_pose << -R_base_local, -turned_left(p_base_m);
    innovation.by_landmark = R_base_local;
    const auto& A = innovation.by_pose;
    const auto& B = innovation.by_landmark;
    const Eigen::Matrix2d cross = A * covariance_.block<3, 2>(0, m) * B.transpose();
    innovation.covariance_m2 = A * covariance_.topLeftCorner<3, 3>() * A.transpose() + cross +
                               cross.transpose() + B * covariance_.block<2, 2>(m, m) * B.transpose() +
                               sighting.covariance_m2;
    return innovation;
}

void LandmarkFilter::update(std::size_t landmark, const Innovation& innovation) {
    const Eigen::Index m = at(landmark);
    const Eigen::MatrixX2d PHt = covariance_.leftCols<3>() * innovation.by_pose.transpose() +
                                 covariance_.middleCols<2>(m) * innovation.by_landmark.transpose();
    // K S Kᵀ as a product with its own transpose stays symmetric to the last bit.
    const Eigen::LLT<Eigen::Matrix2d> S(innovation.covariance_m2);
    const Eigen::MatrixX2d W = S.matrixL().solve(PHt.transpose()).transpose();
    state_ += PHt * S.solve(innovation.off_m);
    state_[2] = wrap_to_pi(state_[2]);
    covariance_.noalias() -= W * W.transpose();
}

void LandmarkFilter::add(const Sighting& sighting) {
    const Eigen::Index n = state_.size();
    const Eigen::Matrix2d R_local_base = rotation(state_[2]);
    const Eigen::Vector2d way_m = R_local_base * sighting.p_base_m;
    Eigen::Matrix<double, 2, 3> by_pose;
    by_pose << Eigen::Matrix2d::Identity(), turned_left(way_m);
    state_.conservativeResize(n + 2);
    state_.tail<2>() = state_.head<2>() + way_m;
    covariance_.conservativeResize(n + 2, n + 2);
    covariance_.bottomLeftCorner(2, n) = by_pose * covariance_.topLeftCorner(3, n);
    covariance_.topRightCorner(n, 2) = covariance_.bottomLeftCorner(2, n).transpose();
    covariance_.bottomRightCorner<2, 2>() =
        by_pose * covariance_.topLeftCorner<3, 3>() * by_pose.transpose() +
        R_local_base * sighting.covariance_m2 * R_local_base.transpose();
}

void LandmarkFilter::remove(std::size_t landmark) {
    const Eigen::Index m = at(landmark), n = state_.size(), behind = n - m - 2;
    state_.segment(m, behind) = state_.tail(behind).eval();
    state_.conservativeResize(n - 2);
    covariance_.middleRows(m, behind) = covariance_.bottomRows(behind).eval();
    covariance_.middleCols(m, behind) = covariance_.rightCols(behind).eval();
    covariance_.conservativeResize(n - 2, n - 2);
}

void LandmarkFilter::begin_anew() {
    const Eigen::Index n = state_.size();
    const Eigen::Matrix2d R_base_local = rotation(state_[2]).transpose();
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t k = 0; k < landmarks(); ++k) {
        const Eigen::Index m = at(k);
        const Eigen::Vector2d p_base_m = R_base_local * (state_.segment<2>(m) - state_.head<2>());
        J.block<2, 2>(m, 0) = -R_base_local;
        J.block<2, 1>(m, 2) = -turned_left(p_base_m);
        J.block<2, 2>(m, m) = R_base_local;
        state_.segment<2>(m) = p_base_m;
    }
    state_.head<3>().setZero();
    covariance_ = propagated(J, covariance_);
    covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

}  // namespace loopline::landmark_odometry
