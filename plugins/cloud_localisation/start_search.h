/// Where in a finished cloud is the vehicle, when no more is known than about where it is and perhaps where
/// it heads? One sweep, seen from above, is laid on what stands upright in the map at all places and headings
/// in question; the best of them are matched in space, coarse to fine. A wrong start is worse than none: it
/// counts only if the sweep fits well, holds the pose, and fits no other place nearly as well.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "api/worker_pool.h"
#include "cloud_localisation/frozen_cloud.h"
#include "lidar_mapping/registration.h"

namespace loopline::cloud_localisation {

struct StartSettings {
    double range_m = 60;  ///< what is farther away is not looked at
    double window_sigmas = 3;
    double max_window_m = 30;  ///< to each side; less is known too little of
    double step_m = 0.5, step_rad = 2 * M_PI / 180;
    int places = 8;     ///< the best of them, which are matched in space
    int columns = 250;  ///< of the sweep that are laid on the map at most
    int min_columns = 25;
    double min_fit = 0.6;  ///< part of the returns from upright things that are where the map has some
    double rival = 0.8;    ///< another place that fits so well, as a part of the best one, makes it ambiguous
    double rival_m = 1, rival_rad = 5 * M_PI / 180;  ///< another place: farther than this, or so turned
    lidar_mapping::RegistrationSettings registration;
};

/// A point of the vehicle, which is known to be at a place of the map, and perhaps a heading.
struct StartRegion {
    Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero(), p_base_m = Eigen::Vector3d::Zero();
    double sigma_m = 0;  ///< of its x and of its y
    double sigma_z_m = std::numeric_limits<double>::infinity();
    double yaw_rad = 0, sigma_yaw_rad = std::numeric_limits<double>::infinity();  ///< of the vehicle
};

/// What came of a look, for people too.
struct StartLook {
    bool found = false;
    lidar_mapping::MotionState state;  ///< in the middle of the sweep
    double fit = 0, rival_fit = 0;
    std::string reason = "nothing was searched for yet";  ///< why the place is not known
};

/// `points`: of the sweep, evenly in space; `matched`: fewer of them, to be matched. `velocity` of the
/// vehicle, a second, along its axes.
StartLook look_for_start(const FrozenCloud& map, const std::vector<lidar_mapping::SweepPoint>& points,
                         const std::vector<lidar_mapping::SweepPoint>& matched, const Twist3& velocity,
                         const StartRegion& region, const StartSettings& settings, WorkerPool& workers);

/// Part of points that are where the map has some, whether these make a surface, as of a wall, or not, as of
/// a tree.
double fit_in_map(const FrozenCloud& map, const std::vector<lidar_mapping::SweepPoint>& points,
                  const lidar_mapping::MotionState& state);

}  // namespace loopline::cloud_localisation
