/// The pose of a sweep in the map, by iterated least squares: returns are drawn onto the planes and edges that
/// the map has around them, while the motion during the sweep follows from the pose that is sought.
#pragma once

#include <vector>

#include "api/pose3_motion.h"
#include "lidar_mapping/scan_sampling.h"
#include "lidar_mapping/surface_map.h"

namespace loopline::lidar_mapping {

/// What is known before the scan speaks.
struct MotionPrior {
    Pose3 T_map_before;      ///< at the middle of the sweep before
    double duration_s = 0;   ///< since then
    Pose3 T_map_base;        ///< predicted for the middle of this one
    Twist3 velocity_change;  ///< of the two last motions, a second; half of it goes on during the sweep
    Matrix6d information = Matrix6d::Zero();  ///< of (shift, turn) along map axes about T_map_base
};

struct RegistrationSettings {
    double sigma_range_m = 0.02;
    double loss_scale = 2;  ///< residual in standard deviations from which on it counts less (Cauchy)
    int iterations = 12;
    double enough_m = 5e-4, enough_rad = 5e-5;
};

struct Registration {
    Pose3 T_map_base;    ///< at the middle of the sweep
    Twist3 velocity;     ///< during it, a second, along the vehicle's axes
    Matrix6d information = Matrix6d::Zero();  ///< of the scan alone; (shift, turn) along map axes, about its own position
    double fit = 0;      ///< part of the points on a surface
    double rms_sigmas = 0;
    int used = 0, iterations = 0;
    bool converged = false;
};

/// Where a point of the sweep was seen from the vehicle at the middle of the sweep, to second order.
inline Eigen::Vector3d undistorted(const SweepPoint& point, const Twist3& velocity) {
    const Eigen::Vector3d p = point.p_base_m.cast<double>();
    const double s = point.time_s;
    const Eigen::Vector3d step = velocity.shift_m + velocity.turn_rad.cross(p);
    return p + s * step + (s * s / 2) * velocity.turn_rad.cross(step);
}

Registration register_sweep(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                            const MotionPrior& prior, const RegistrationSettings& settings);

}  // namespace loopline::lidar_mapping
