/// Pose and velocity of the vehicle in the middle of a sweep, and how the two go on to the next one: as if
/// nothing accelerated, but for noise. What the velocity has then become tells how it changed, and the sweep
/// itself how it moved unevenly within it.
#pragma once

#include <Eigen/Core>

#include "api/pose3_motion.h"

namespace loopline::lidar_mapping {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;
using Vector12d = Eigen::Matrix<double, 12, 1>;
/// Errors of all that a sweep is undistorted by: (shift, turn) of its pose, of its velocity, of the
/// acceleration and of the jerk within it. The last two are not carried on to the next sweep.
constexpr int sweep_errors = 24;
using SweepMatrix = Eigen::Matrix<double, sweep_errors, sweep_errors>;
using SweepVector = Eigen::Matrix<double, sweep_errors, 1>;

struct MotionState {
    Pose3 T_map_base;
    Twist3 velocity;         ///< a second, along the vehicle's axes
    Twist3 velocity_before;  ///< that it had so much earlier:
    double duration_s = 0;   ///< 0 if that is not known
    /// What nothing tells before the sweep, as where a wheel goes over a bump: by how much the acceleration
    /// in its middle is another than the mean one since the velocity before, and the jerk; vehicle's axes.
    Twist3 acceleration_off, jerk;
    /// Standard deviations of these, (shift, turn), before the sweep is looked at.
    Vector6d sigma_acceleration_off = Vector6d::Zero(), sigma_jerk = Vector6d::Zero();
    /// That another odometry tells since a sweep last held all directions.
    double way_on_trust_m = 0;
    /// Of shift, turn, velocity and rate of turn, all along the map's axes, about the vehicle's own position:
    /// what is known relative to the map around it.
    Matrix12d covariance = Matrix12d::Zero();
};

/// From the middle of a sweep on.
class SweepMotion {
 public:
    explicit SweepMotion(const Twist3& velocity) : velocity_(velocity) {}
    explicit SweepMotion(const MotionState& state)
        : velocity_(state.velocity),
          half_acceleration_(state.acceleration_off * 0.5),
          sixth_of_jerk_(state.jerk * (1.0 / 6)) {
        if (!(state.duration_s > 0)) return;
        half_per_s_ = 0.5 / state.duration_s;
        half_acceleration_ = half_acceleration_ + (state.velocity - state.velocity_before) * half_per_s_;
    }
    Twist3 after(double s) const {
        return velocity_ * s + half_acceleration_ * (s * s) + sixth_of_jerk_ * (s * s * s);
    }
    /// How far what is after(s) goes with the velocity.
    double by_velocity_s(double s) const { return s + s * s * half_per_s_; }

 private:
    Twist3 velocity_, half_acceleration_, sixth_of_jerk_;
    double half_per_s_ = 0;
};

struct MotionNoise {
    double sigma_acceleration_mps2 = 3;
    double sigma_turn_radps2 = 0.3;
    double sigma_first_speed_mps = 1;  ///< about the one that is tried
    double sigma_first_turn_radps = 0.3;

    /// Of (shift, turn) of accelerations.
    Vector6d sigmas() const {
        return (Vector6d() << Eigen::Vector3d::Constant(sigma_acceleration_mps2),
                Eigen::Vector3d::Constant(sigma_turn_radps2))
            .finished();
    }
};

/// A vehicle of which nothing is known but that it is at the map's origin.
MotionState first_state(const MotionNoise& noise);
MotionState predict(const MotionState& state, double duration_s, const MotionNoise& noise);
/// Of the motion within the next sweep: what nothing tells before.
void expect_unevenness(MotionState& next, const MotionNoise& noise);

/// Where the vehicle is `after_s` after the middle of the sweep, or before it.
Pose3 pose_near(const MotionState& state, double after_s);

/// With the error of its 12 parameters put into it.
MotionState moved_by(const MotionState& state, const Vector12d& step);
/// What moved_by() would have to be given to lead from `from` to `to`.
Vector12d difference(const MotionState& to, const MotionState& from);

/// The same with the motion within the sweep.
MotionState sweep_moved_by(const MotionState& state, const SweepVector& step);
SweepVector sweep_difference(const MotionState& to, const MotionState& from);
/// Before the sweep is looked at.
SweepMatrix sweep_covariance(const MotionState& predicted);

}  // namespace loopline::lidar_mapping
