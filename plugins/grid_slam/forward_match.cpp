#include "grid_slam/forward_match.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace loopline::grid_slam {
namespace {

grid_map::SearchWindow window_for(const Pose2& T_map_prior, const Eigen::Matrix3d& covariance, double cell_m,
                                  const ForwardSettings& settings) {
    grid_map::SearchWindow window;
    window.T_map_center = T_map_prior;
    window.sigma_x_m = std::sqrt(covariance(0, 0));
    window.sigma_y_m = std::sqrt(covariance(1, 1));
    window.sigma_phi_rad = std::sqrt(covariance(2, 2));
    const auto steps = [&](double sigma, double most, double step) {
        return static_cast<int>(std::ceil(std::min(settings.window_sigmas * sigma, most) / step));
    };
    window.cells_x = steps(window.sigma_x_m, settings.max_window_m, cell_m);
    window.cells_y = steps(window.sigma_y_m, settings.max_window_m, cell_m);
    window.heading_step_rad = settings.heading_step_rad;
    window.headings = steps(window.sigma_phi_rad, settings.max_window_rad, window.heading_step_rad);
    return window;
}

template <class Surfaces>
ForwardMatch match_on(const grid_map::ScanGrid& grid, const Surfaces& surfaces, const grid_map::Frame& frame,
                      const Pose2& T_map_prior, const Eigen::Matrix3d& prior_covariance,
                      const ForwardSettings& settings) {
    ForwardMatch match;
    match.T_map_base = T_map_prior;
    match.covariance = prior_covariance;
    const auto points = grid_map::search_points(frame, static_cast<std::size_t>(settings.search_points));
    if (points.empty()) return match;
    const auto found = grid_map::branch_and_bound(
        grid, points, window_for(T_map_prior, prior_covariance, grid.cell_m(), settings));
    const Eigen::Matrix3d prior_information = prior_covariance.inverse();
    grid_map::ScanFit fit = grid_map::refine(surfaces, frame, found ? found->T_map_base : T_map_prior,
                                             T_map_prior, prior_information, settings.refinement);
    match.fit = fit.fit;
    const double range_m = grid_map::mean_range_m(frame);
    match.degeneracy = grid_map::degeneracy(fit, range_m, settings.sigma_degenerate_m);
    if (match.degeneracy.free_directions > 0)
        grid_map::forget_free_directions(fit, T_map_prior, range_m, settings.sigma_degenerate_m);
    if (fit.fit < settings.min_fit || fit.used < settings.min_returns) return match;
    match.matched = true;
    match.T_map_base = fit.T_map_base;
    match.information = fit.information;
    match.gradient = fit.gradient;
    match.covariance = (prior_information + fit.information).inverse();
    return match;
}

}  // namespace

ForwardMatch match_forward(const grid_map::ScanGrid& grid, const grid_map::Frame& frame,
                           const Pose2& T_map_prior, const Eigen::Matrix3d& prior_covariance,
                           const ForwardSettings& settings) {
    return match_on(grid, grid, frame, T_map_prior, prior_covariance, settings);
}

ForwardMatch match_forward(const grid_map::ScanGrid& grid, const grid_map::SurfaceIndex& surfaces,
                           const grid_map::Frame& frame, const Pose2& T_map_prior,
                           const Eigen::Matrix3d& prior_covariance, const ForwardSettings& settings) {
    return match_on(grid, surfaces, frame, T_map_prior, prior_covariance, settings);
}

}  // namespace loopline::grid_slam
