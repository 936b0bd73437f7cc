#include "api/pose_covariance.h"

namespace loopline {
namespace {

constexpr Eigen::Index rows_of_planar[3] = {0, 1, 5};             // x, y, yaw
constexpr Eigen::Index planar_of_row[6] = {0, 1, -1, -1, -1, 2};  // the inverse

Eigen::Matrix3d planar_part(const Matrix6d& matrix) {
    Eigen::Matrix3d part;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            part(row, column) = matrix(rows_of_planar[row], rows_of_planar[column]);
    return part;
}

}  // namespace

void PoseCovariance::set(const Matrix6d& matrix) {
    planar_ = planar_part(matrix);
    if (this->matrix() != matrix) spatial_ = std::make_shared<const Matrix6d>(matrix);  // where NaN is, too
}

PoseCovariance PoseCovariance::planar(const Eigen::Matrix3d& matrix) {
    PoseCovariance covariance;
    covariance.planar_ = matrix;
    return covariance;
}

double PoseCovariance::operator()(Eigen::Index row, Eigen::Index column) const {
    if (spatial_) return (*spatial_)(row, column);
    const Eigen::Index planar_row = planar_of_row[row], planar_column = planar_of_row[column];
    return planar_row < 0 || planar_column < 0 ? 0 : planar_(planar_row, planar_column);
}

Matrix6d PoseCovariance::matrix() const {
    if (spatial_) return *spatial_;
    Matrix6d matrix = Matrix6d::Zero();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            matrix(rows_of_planar[row], rows_of_planar[column]) = planar_(row, column);
    return matrix;
}

Eigen::Matrix3d PoseCovariance::planar() const {
    return spatial_ ? planar_part(*spatial_) : planar_;
}

}  // namespace loopline
