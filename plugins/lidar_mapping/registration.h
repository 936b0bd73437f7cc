/// Pose and velocity of the vehicle by a sweep and the map, as an iterated Kalman update: returns are drawn
/// onto the planes and edges that the map has around them, each undistorted by the velocity that is sought.
#pragma once

#include <vector>

#include "lidar_mapping/motion_state.h"
#include "lidar_mapping/scan_sampling.h"
#include "lidar_mapping/surface_map.h"

namespace loopline::lidar_mapping {

struct RegistrationSettings {
    double loss_scale = 2;  ///< residual in standard deviations from which on it counts less (Cauchy)
    int iterations = 12;
    double enough_m = 5e-4, enough_rad = 5e-5;
};

struct Registration {
    MotionState state;  ///< in the middle of the sweep
    /// Of the sweep alone: (shift, turn) along map axes, about the vehicle's own position.
    Matrix6d information = Matrix6d::Zero();
    double fit = 0;  ///< part of the points on a surface
    double rms_sigmas = 0;
    int used = 0, iterations = 0;
    bool converged = false;
};

/// Where a point of the sweep was seen from the vehicle in the middle of the sweep, to second order.
inline Eigen::Vector3d undistorted(const SweepPoint& point, const Twist3& velocity) {
    const Eigen::Vector3d p = point.p_base_m.cast<double>();
    const double s = point.time_s;
    const Eigen::Vector3d step = velocity.shift_m + velocity.turn_rad.cross(p);
    return p + s * step + (s * s / 2) * velocity.turn_rad.cross(step);
}

Registration register_sweep(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                            const MotionState& predicted, const RegistrationSettings& settings);

}  // namespace loopline::lidar_mapping
