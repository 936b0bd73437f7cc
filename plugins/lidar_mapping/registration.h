/// Pose and velocity of the vehicle by a sweep and the map, as an iterated Kalman update: returns are drawn
/// onto the planes and edges that the map has around them, each undistorted by the motion that is sought.
#pragma once

#include <vector>

#include "api/worker_pool.h"
#include "lidar_mapping/motion_state.h"
#include "lidar_mapping/scan_sampling.h"
#include "lidar_mapping/surface_map.h"

namespace loopline::lidar_mapping {

struct RegistrationSettings {
    double loss_scale = 2;  ///< residual in standard deviations from which on it counts less (Cauchy)
    int iterations = 12;
    std::size_t smallest_size = 0;  ///< of the map's cubes that are looked at
    double enough_m = 5e-4, enough_rad = 5e-5;
    /// A direction that the scan holds no better than this is not observed; a turn counts by what it moves at
    /// the mean range.
    double sigma_degenerate_m = 0.3;
    /// Nor is one that so few points hold alone: no others could contradict them.
    std::size_t few = 10;
};

/// Directions of motion of which the surroundings say nothing, as on a level field or along a tunnel (after
/// Zhang, Kaess, Singh 2016, "On degeneracy of optimization-based state estimation problems").
struct Degeneracy {
    int free_directions = 0;
    double weakest_sigma_m = 0;  ///< along the weakest direction, by the scan alone
    Eigen::Matrix<double, 6, 1> weakest = Eigen::Matrix<double, 6, 1>::Zero();  ///< that direction
};

struct Registration {
    MotionState state;  ///< in the middle of the sweep
    /// Of (shift, turn): what of the pose's covariance the errors of sweep and map make, and what those of
    /// the prediction. The sum is that of the state.
    Matrix6d by_scan = Matrix6d::Zero(), by_prediction = Matrix6d::Zero();
    Matrix6d predicted = Matrix6d::Identity();  ///< covariance of the predicted pose
    Matrix6d left = Matrix6d::Zero();           ///< what of an error of the predicted pose is left in it
    Eigen::Matrix<double, 6, 1> correction = Eigen::Matrix<double, 6, 1>::Zero();  ///< of that pose
    double age_sweeps = 0;  ///< of the surfaces, in sweeps of the map, mean by what each point counts
    double mean_range_m = 1;
    Degeneracy degeneracy;
    double fit = 0;  ///< part of the points on a surface
    double rms_sigmas = 0;
    double support = 0;  ///< number of points on a surface, less the farther off they are
    int used = 0, iterations = 0;
    bool converged = false;
    /// Mean of what a point on a surface counts, 0 to 1.
    double agreement() const { return used > 0 ? support / used : 0; }
};

/// Where a point of the sweep was seen from the vehicle in the middle of the sweep, to second order.
inline Eigen::Vector3d undistorted(const SweepPoint& point, const SweepMotion& motion) {
    const Eigen::Vector3d p = point.p_base_m.cast<double>();
    const Twist3 moved = motion.after(static_cast<double>(point.time_s));
    const Eigen::Vector3d step = moved.shift_m + moved.turn_rad.cross(p);
    return p + step + 0.5 * moved.turn_rad.cross(step);
}

/// From `start`, if there is one, and else from the prediction.
Registration register_sweep(const SurfaceMap& map, const std::vector<SweepPoint>& points,
                            const MotionState& predicted, const RegistrationSettings& settings,
                            WorkerPool& workers, const MotionState* start = nullptr);

}  // namespace loopline::lidar_mapping
