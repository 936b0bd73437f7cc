/// The pose of a scan in the map below the size of a cell: returns are drawn onto the surfaces of the map, by
/// iterated least squares, with what is known beforehand as one more observation. (Point to line: Censi 2008;
/// the map's surfaces are sums over cells, as in Biber and Strasser 2003.)
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "grid_map/frame.h"
#include "grid_map/scan_grid.h"
#include "grid_map/surface_index.h"

namespace loopline::grid_map {

struct RefinementSettings {
    double sigma_m = 0.02;                      ///< of a return about the map's surface, along the beam
    double sigma_angle_rad = 0.3 * M_PI / 180;  ///< of the beam's direction, its width included
    double reach_m = 0.15;                      ///< farther surfaces are not of a return
    int iterations = 10;
    double enough_m = 5e-4, enough_rad = 1e-4;  ///< a smaller step is the last one
    double give_up_fit = 0;      ///< a fit that is worse than this after three iterations is no fit
    double correlation_m = 0.1;  ///< returns as close together along a wall err together
};

/// What the scan says about its pose, at the pose where prior and scan agree best.
struct ScanFit {
    Pose2 T_map_base;  ///< the most likely pose, the prior included
    Eigen::Matrix3d information =
        Eigen::Matrix3d::Zero();  ///< of the scan alone, on (x, y, phi) of the map frame
    Eigen::Vector3d gradient =
        Eigen::Vector3d::Zero();  ///< of the scan alone: information * (its own optimum - pose)
    double fit = 0;               ///< part of the returns that lie on a surface of the map
    double rms_m = 0;             ///< of their distances
    int used = 0;                 ///< returns that lie on a surface
    bool converged = false;
};

/// `prior_information` may be zero, or singular.
ScanFit refine(const ScanGrid& grid, const Frame& frame, const Pose2& T_map_start, const Pose2& T_map_prior,
               const Eigen::Matrix3d& prior_information, const RefinementSettings& settings);
/// The same against a few frames, in the frame of the first of them.
ScanFit refine(const SurfaceIndex& map, const Frame& frame, const Pose2& T_map_start,
               const Pose2& T_map_prior, const Eigen::Matrix3d& prior_information,
               const RefinementSettings& settings);

/// Which motions the scan does not hold: eigenvalues of the information below the limit (1 / sigma^2), turned
/// to metres by the mean distance of the returns.
struct Degeneracy {
    int free_directions = 0;     ///< 0: the scan holds its pose
    double weakest_sigma_m = 0;  ///< standard deviation along the weakest direction
    double direction_rad = 0;    ///< of the weakest motion, map frame
};
Degeneracy degeneracy(const ScanFit& fit, double mean_range_m, double sigma_limit_m);

/// Along directions that are not observed the pose becomes that of the prior, and information and gradient
/// nothing: what little there seems to be is noise of normals, and would hold the vehicle where it was
/// thought to be, scan after scan.
void forget_free_directions(ScanFit& fit, const Pose2& T_map_prior, double mean_range_m,
                            double sigma_limit_m);

}  // namespace loopline::grid_map
