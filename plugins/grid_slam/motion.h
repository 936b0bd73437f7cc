/// What is known of the motion from one scan to the next without looking at the scans.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "api/pose2.h"

namespace loopline::grid_slam {

/// A covariance of (x, y, phi) along axes that are turned by `phi_rad` against those it is given along.
inline Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, double phi_rad) {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    const double c = std::cos(phi_rad), s = std::sin(phi_rad);
    turn.topLeftCorner<2, 2>() << c, -s, s, c;
    return turn * covariance * turn.transpose();
}

/// What an error of (x, y, phi) is at a place that lies `way_m` from it: the heading's error turns the way.
/// Both along the same axes.
inline Eigen::Matrix3d carried_by(const Eigen::Vector2d& way_m) {
    Eigen::Matrix3d carried = Eigen::Matrix3d::Identity();
    carried(0, 2) = -way_m.y();
    carried(1, 2) = way_m.x();
    return carried;
}

/// carried_by(way) * covariance * carried_by(way)', written out.
struct Carried {
    double xx, xy, xp, yy, yp, pp;
    Carried(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& way_m) : pp(covariance(2, 2)) {
        const double a = -way_m.y(), b = way_m.x();
        xp = covariance(0, 2) + a * pp;
        yp = covariance(1, 2) + b * pp;
        xx = covariance(0, 0) + a * (covariance(0, 2) + xp);
        yy = covariance(1, 1) + b * (covariance(1, 2) + yp);
        xy = covariance(0, 1) + a * covariance(1, 2) + b * xp;
    }
    Eigen::Matrix3d matrix() const {
        return (Eigen::Matrix3d() << xx, xy, xp, xy, yy, yp, xp, yp, pp).finished();
    }
};
inline Eigen::Matrix3d carried(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& way_m) {
    return Carried(covariance, way_m).matrix();
}

struct Motion {
    Pose2 T_before_now;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, phi), along the axes of `before`
};

/// T_a_c and its covariance from T_a_b and T_b_c.
inline Motion operator*(const Motion& a_b, const Motion& b_c) {
    const double c = std::cos(a_b.T_before_now.phi_rad), s = std::sin(a_b.T_before_now.phi_rad);
    const Eigen::Vector2d way(c * b_c.T_before_now.x_m - s * b_c.T_before_now.y_m,
                              s * b_c.T_before_now.x_m + c * b_c.T_before_now.y_m);
    const Eigen::Matrix3d carried = carried_by(way);
    return {a_b.T_before_now * b_c.T_before_now, carried * a_b.covariance * carried.transpose() +
                                                     turned(b_c.covariance, a_b.T_before_now.phi_rad)};
}

/// The way back: T_now_before, along the axes of `now`.
inline Motion inverse(const Motion& motion) {
    const double c = std::cos(motion.T_before_now.phi_rad), s = std::sin(motion.T_before_now.phi_rad);
    const Pose2 T_now_before = motion.T_before_now.inverse();
    // (t', phi') = (-R' t, -phi), with d(-R' t) = -R' dt + J R' t dphi, J a quarter turn to the left.
    Eigen::Matrix3d by = Eigen::Matrix3d::Zero();
    by.topLeftCorner<2, 2>() << -c, -s, s, -c;
    by(0, 2) = T_now_before.y_m;
    by(1, 2) = -T_now_before.x_m;
    by(2, 2) = -1;
    return {T_now_before, by * motion.covariance * by.transpose()};
}

/// How far wheels can be trusted; standard deviations grow in proportion to the motion between two scans,
/// since what wheels get wrong they get wrong all along. What no motion explains walks at random with the
/// time, so that it adds up to the same however often the laser turns.
struct WheelNoise {
    double sigma_rest_m = 0.02;              ///< after 1 s without any motion
    double sigma_way_m = 0.1;                ///< after 1 m
    double sigma_rest_rad = 2 * M_PI / 180;  ///< after 1 s without any motion
    double sigma_turn = 0.1;                 ///< of a turn, as a part of it
    double sigma_way_rad = 3 * M_PI / 180;   ///< after 1 m
};

/// `duration_s`: between the two; stamps of odd logs may say anything, so no more than 1 s counts, and no
/// less than a fast laser takes for a turn.
inline Motion wheel_motion(const Pose2& T_before_now, double duration_s, const WheelNoise& noise) {
    const double way_m = T_before_now.translation().norm(),
                 root_s = std::sqrt(std::clamp(duration_s, 0.01, 1.0));
    const double sigma_m = noise.sigma_rest_m * root_s + noise.sigma_way_m * way_m,
                 sigma_rad = noise.sigma_rest_rad * root_s +
                             noise.sigma_turn * std::abs(T_before_now.phi_rad) + noise.sigma_way_rad * way_m;
    Motion motion{T_before_now, Eigen::Matrix3d::Zero()};
    motion.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
    return motion;
}

}  // namespace loopline::grid_slam
