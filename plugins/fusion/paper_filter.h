/// The light filter of the paper (Yu, Zheng, Ou, Wang 2022, 1.4): position and angles as plain numbers, the
/// motion before as prediction, and sensors one after the other with a linear observation. Rows C7, C8.
#pragma once

#include <Eigen/Core>
#include <initializer_list>

#include "api/pose3.h"

namespace loopline::fusion {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// s = (x, y, z, angle about x, y, z): roll, pitch, yaw.
Vector6d as_numbers(const Pose3& pose);
Pose3 as_pose(const Vector6d& numbers);

class PaperFilter {
 public:
    PaperFilter() = default;
    PaperFilter(const Pose3& T_map_base, const Matrix6d& covariance)
        : s_(as_numbers(T_map_base)), P_(covariance) {}

    /// Algorithm 3, lines 2 and 3, with eq. (4) to (6): the vehicle goes on as in the step before, in a
    /// plane.
    void predict(double way_m, double turn_rad, const Matrix6d& R);
    /// Lines 4 to 6: components `which` of the state as a sensor tells them. What it does not tell is left
    /// out (row C8) instead of being filled with zeros.
    void observe(const Pose3& told, std::initializer_list<int> which, const Vector6d& sigma);
    /// Where frames are not fused (row C9): the lidar's motion alone, and its noise on top.
    void follow(const Pose3& T_before_now, const Vector6d& sigma);

    Pose3 pose() const { return as_pose(s_); }
    const Matrix6d& covariance() const { return P_; }

 private:
    template <class Archive>
    friend void fields(Archive&, PaperFilter&);
    Vector6d s_ = Vector6d::Zero();
    Matrix6d P_ = Matrix6d::Zero();
};

}  // namespace loopline::fusion
