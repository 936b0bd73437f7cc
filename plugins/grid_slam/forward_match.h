/// A scan against the map of its surroundings, with what the motion says about its place (rows B2 and B4 of
/// the method).
#pragma once

#include "grid_map/refinement.h"
#include "grid_map/search.h"
#include "grid_slam/motion.h"

namespace loopline::grid_slam {

struct ForwardSettings {
    double window_sigmas = 2.5;  ///< half of the search window, in standard deviations of the motion
    double max_window_m = 1;     ///< but not more
    double max_window_rad = 40 * M_PI / 180;
    double heading_step_rad = 0.5 * M_PI / 180;
    int search_points = 60;
    int min_returns = 20;  ///< on a surface of the map; by fewer, the motion alone counts
    /// Part of the returns on a surface, below which the motion alone counts: among furniture that was moved,
    /// a third of any scan comes to lie on some surface.
    double min_fit = 0.4;
    /// And so it does if the distances of the returns from their surfaces are more than this part of the
    /// reach: by chance alone they would be evenly spread over it, and their RMS 0.58 of it.
    double max_rms_reach = 0.4;
    /// Wheels slip, and stamps are wrong now and then: a scan of which less than this part fits is searched
    /// for once more, so many times as far around and no less than so far. It is there if it fits better by
    /// so much.
    double good_fit = 0.6, better_fit = 0.15;
    double wider_window = 4, wider_least_m = 0.3, wider_least_rad = 10 * M_PI / 180;
    double wider_min_likelihood = 0.5;
    double sigma_degenerate_m = 0.3;  ///< a direction that the scan holds no better than this is not observed
    grid_map::RefinementSettings refinement;
};

struct ForwardMatch {
    Pose2 T_map_base;
    Eigen::Matrix3d covariance =
        Eigen::Matrix3d::Zero();  ///< of (x, y, phi) about the map around it, map axes
    double fit = 0;
    bool matched = false;  ///< else the motion alone counts
    bool motion_was_wrong =
        false;  ///< matched where the motion had not led, farther off than its noise explains
    /// What the scan sees is new, and went into the map where the motion led: from here on the pose is as
    /// right as the map around it.
    bool begins_map = false;
    /// Of the scan alone, around T_map_base: log-likelihood = gradient' d - d' information d / 2.
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    grid_map::Degeneracy degeneracy;
};

/// `prior_covariance`: of (x, y, phi), map axes.
ForwardMatch match_forward(const grid_map::ScanGrid& grid, const grid_map::Frame& frame,
                           const Pose2& T_map_prior, const Eigen::Matrix3d& prior_covariance,
                           const ForwardSettings& settings);
/// The same where the surfaces of the map are kept beside the grid that is searched.
ForwardMatch match_forward(const grid_map::ScanGrid& grid, const grid_map::SurfaceIndex& surfaces,
                           const grid_map::Frame& frame, const Pose2& T_map_prior,
                           const Eigen::Matrix3d& prior_covariance, const ForwardSettings& settings);

}  // namespace loopline::grid_slam
