#include "grid_slam/forward_match.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace loopline::grid_slam {
namespace {

/// A scan's fit, and what of the motion is in it.
struct Fitted {
    grid_map::ScanFit scan;
    Eigen::Matrix3d prior_information;
};

template <class Surfaces>
class Matching {
 public:
    Matching(const grid_map::ScanGrid& grid, const Surfaces& surfaces, const grid_map::Frame& frame,
             const Pose2& T_map_prior, const Eigen::Matrix3d& prior_covariance,
             const ForwardSettings& settings)
        : grid_(grid),
          surfaces_(surfaces),
          frame_(frame),
          T_map_prior_(T_map_prior),
          prior_covariance_(prior_covariance),
          settings_(settings),
          points_(grid_map::search_points(frame, static_cast<std::size_t>(settings.search_points))) {}

    ForwardMatch match() const {
        ForwardMatch match;
        match.T_map_base = T_map_prior_;
        match.covariance = prior_covariance_;
        if (points_.empty()) return match;
        Fitted fitted = fit_near();
        match.matched = is_match(fitted.scan);
        if (!match.matched || fitted.scan.fit < settings_.good_fit)
            if (const auto wider = fit_wider(match.matched ? fitted.scan.fit + settings_.better_fit : 0)) {
                match.matched = match.motion_was_wrong = true;
                fitted = *wider;
            }
        grid_map::ScanFit& fit = fitted.scan;
        match.fit = fit.fit;
        const double range_m = grid_map::mean_range_m(frame_);
        match.degeneracy = grid_map::degeneracy(fit, range_m, settings_.sigma_degenerate_m);
        if (match.degeneracy.free_directions > 0)
            grid_map::forget_free_directions(fit, T_map_prior_, range_m, settings_.sigma_degenerate_m);
        if (!match.matched) return match;
        match.T_map_base = fit.T_map_base;
        match.information = fit.information;
        match.gradient = fit.gradient;
        match.covariance = (fitted.prior_information + fit.information).inverse();
        return match;
    }

 private:
    bool is_match(const grid_map::ScanFit& fit) const {
        return fit.fit >= settings_.min_fit && fit.used >= settings_.min_returns &&
               fit.rms_m <= settings_.max_rms_reach * settings_.refinement.reach_m;
    }

    grid_map::SearchWindow window(double sigmas, double least_m, double least_rad) const {
        grid_map::SearchWindow window;
        window.T_map_center = T_map_prior_;
        window.sigma_x_m = std::sqrt(prior_covariance_(0, 0));
        window.sigma_y_m = std::sqrt(prior_covariance_(1, 1));
        window.sigma_phi_rad = std::sqrt(prior_covariance_(2, 2));
        const auto steps = [&](double sigma, double least, double most, double step) {
            return static_cast<int>(std::ceil(std::min(std::max(sigmas * sigma, least), most) / step));
        };
        window.cells_x = steps(window.sigma_x_m, least_m, settings_.max_window_m, grid_.cell_m());
        window.cells_y = steps(window.sigma_y_m, least_m, settings_.max_window_m, grid_.cell_m());
        window.heading_step_rad = settings_.heading_step_rad;
        window.headings =
            steps(window.sigma_phi_rad, least_rad, settings_.max_window_rad, window.heading_step_rad);
        return window;
    }

    Fitted fit_from(const Pose2& T_map_start, const Eigen::Matrix3d& covariance) const {
        Fitted fitted;
        fitted.prior_information = covariance.inverse();
        fitted.scan = grid_map::refine(surfaces_, frame_, T_map_start, T_map_prior_, fitted.prior_information,
                                       settings_.refinement);
        return fitted;
    }

    /// Where motion and scan agree.
    Fitted fit_near() const {
        const auto found = grid_map::branch_and_bound(grid_, points_, window(settings_.window_sigmas, 0, 0));
        return fit_from(found ? found->T_map_base : T_map_prior_, prior_covariance_);
    }

    /// Farther around, where the scan alone says where it is. There the motion was wrong, by as much as the
    /// scan is off, and counts as little.
    std::optional<Fitted> fit_wider(double min_fit) const {
        auto wider = window(settings_.window_sigmas * settings_.wider_window, settings_.wider_least_m,
                            settings_.wider_least_rad);
        wider.sigma_x_m = wider.sigma_y_m = wider.sigma_phi_rad = std::numeric_limits<double>::infinity();
        wider.min_score =
            static_cast<int>(settings_.wider_min_likelihood * grid_map::ScanGrid::full_likelihood *
                             static_cast<double>(points_.size()));
        const auto found = grid_map::branch_and_bound(grid_, points_, wider);
        if (!found) return std::nullopt;
        const Eigen::Vector3d off(found->T_map_base.x_m - T_map_prior_.x_m,
                                  found->T_map_base.y_m - T_map_prior_.y_m,
                                  wrap_to_pi(found->T_map_base.phi_rad - T_map_prior_.phi_rad));
        Fitted fitted = fit_from(found->T_map_base, prior_covariance_ + off * off.transpose());
        if (!is_match(fitted.scan) || fitted.scan.fit < std::max(min_fit, settings_.good_fit))
            return std::nullopt;
        return fitted;
    }

    const grid_map::ScanGrid& grid_;
    const Surfaces& surfaces_;
    const grid_map::Frame& frame_;
    const Pose2& T_map_prior_;
    const Eigen::Matrix3d& prior_covariance_;
    const ForwardSettings& settings_;
    std::vector<Eigen::Vector2f> points_;
};

}  // namespace

ForwardMatch match_forward(const grid_map::ScanGrid& grid, const grid_map::Frame& frame,
                           const Pose2& T_map_prior, const Eigen::Matrix3d& prior_covariance,
                           const ForwardSettings& settings) {
    return Matching(grid, grid, frame, T_map_prior, prior_covariance, settings).match();
}

ForwardMatch match_forward(const grid_map::ScanGrid& grid, const grid_map::SurfaceIndex& surfaces,
                           const grid_map::Frame& frame, const Pose2& T_map_prior,
                           const Eigen::Matrix3d& prior_covariance, const ForwardSettings& settings) {
    return Matching(grid, surfaces, frame, T_map_prior, prior_covariance, settings).match();
}

}  // namespace loopline::grid_slam
