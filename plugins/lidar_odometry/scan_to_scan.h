/// The motion between two sweeps: edge points drawn onto lines, planar points onto planes, by
/// Levenberg-Marquardt steps on SE(3). Yu et al. 2022, section 1.2; Zhang and Singh 2014, section V.C; what
/// the scene does not hold: Zhang, Kaess, Singh 2016, "On degeneracy of optimization-based state estimation
/// problems".
#pragma once

#include <vector>

#include "api/worker_pool.h"
#include "lidar_odometry/constant_twist.h"
#include "lidar_odometry/correspondences.h"

namespace loopline::lidar_odometry {

struct MatchingSettings {
    CorrespondenceSettings correspondences;
    double loss_scale = 1;  ///< residual in standard deviations from which on it counts less (Cauchy)
    int rounds = 8;         ///< of correspondences
    int steps = 4;          ///< of Levenberg-Marquardt in each
    double enough_m = 1e-3, enough_rad = 5e-5;
    /// A direction that the scene holds no better than this is free; a turn counts by what it moves at the
    /// mean range.
    double sigma_degenerate_m = 0.1;
};

/// What is known of a motion before anything is matched.
struct ExpectedMotion {
    Pose3 T_before_now;
    Matrix6d covariance = Matrix6d::Identity();  ///< of (shift, turn) put in front of T_before_now
    double duration_s = 0.1;                     ///< between the middles of the sweeps, above 0
};

/// Directions of motion of which the two sweeps say nothing.
struct FreeDirections {
    int count = 0;
    double weakest_sigma_m = 0;           ///< along the direction held least, by the sweeps alone
    Vector6d weakest = Vector6d::Zero();  ///< that direction: unit (shift, turn) in the frame of before
    /// The same with a turn as what it moves at the mean range.
    Vector6d weakest_moves_m = Vector6d::Zero();
};

struct MatchedMotion {
    Pose3 T_before_now;
    Matrix6d covariance = Matrix6d::Zero();  ///< of (shift, turn) put in front of T_before_now
    FreeDirections free;
    int lines = 0, planes = 0;  ///< correspondences
    double support = 0;         ///< part of the points that fit, the farther off the less
    double rms_sigmas = 0;      ///< of the residuals that count
    int rounds = 0;
    bool converged = false;
};

/// A residual e = normal . (p - point) of a point of this sweep, seen from before: along the normal of a
/// plane, or along one of two directions across a line.
struct Residual {
    Eigen::Vector3d normal, point_m;  ///< in the frame of before
    double of(const Eigen::Vector3d& p_before_m) const { return normal.dot(p_before_m - point_m); }
    Row6d jacobian(const Eigen::Vector3d& p_before_m, double time_s, const ConstantTwist& motion) const {
        return motion.derivative(normal, p_before_m, time_s);
    }
};
Residual to_plane(const PlaneOfPoints& plane);
std::array<Residual, 2> to_line(const LineOfEdges& line);

/// Matches the features of `now` that are marked so.
MatchedMotion match_sweeps(const ReferenceSweep& before, const SweepFeatures& now,
                           const ExpectedMotion& expected, const MatchingSettings& settings,
                           WorkerPool& workers);

}  // namespace loopline::lidar_odometry
