/// Drives through simple buildings, as true poses and as wheels with honest noise tell them.
#pragma once

#include <Eigen/Cholesky>
#include <random>
#include <vector>

#include "grid_slam/grid_slam.h"
#include "grid_slam/map_frames.h"
#include "grid_slam/motion.h"
#include "property/grid_map_world.h"

namespace loopline::test {

/// True poses at about equal steps along straight ways between corners, which are turned at on the spot.
inline std::vector<Pose2> drive_along(const std::vector<Eigen::Vector2d>& corners_m, double step_m,
                                      double step_rad) {
    std::vector<Pose2> poses;
    for (std::size_t k = 0; k + 1 < corners_m.size(); ++k) {
        const Eigen::Vector2d way = corners_m[k + 1] - corners_m[k];
        const double heading = std::atan2(way.y(), way.x());
        if (!poses.empty()) {
            const double from = poses.back().phi_rad, turn = wrap_to_pi(heading - from);
            const int steps = static_cast<int>(std::ceil(std::abs(turn) / step_rad));
            for (int i = 1; i < steps; ++i)
                poses.push_back({corners_m[k].x(), corners_m[k].y(), wrap_to_pi(from + turn * i / steps)});
        }
        const int steps = static_cast<int>(std::ceil(way.norm() / step_m));
        for (int i = 0; i < steps; ++i) {
            const Eigen::Vector2d p = corners_m[k] + way * i / steps;
            poses.push_back({p.x(), p.y(), heading});
        }
    }
    return poses;
}

/// From each pose to the next, with errors drawn from the covariance that is stated.
inline std::vector<grid_slam::Motion> noisy_motions(const std::vector<Pose2>& truth,
                                                    const Eigen::Vector3d& sigma_per_step,
                                                    std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    std::vector<grid_slam::Motion> motions;
    for (std::size_t k = 1; k < truth.size(); ++k) {
        grid_slam::Motion m{truth[k - 1].inverse() * truth[k], Eigen::Matrix3d::Zero()};
        m.covariance.diagonal() = sigma_per_step.cwiseAbs2();
        const double x = normal(random), y = normal(random), phi = normal(random);
        m.T_before_now = {m.T_before_now.x_m + sigma_per_step.x() * x,
                          m.T_before_now.y_m + sigma_per_step.y() * y,
                          m.T_before_now.phi_rad + sigma_per_step.z() * phi};
        motions.push_back(m);
    }
    return motions;
}

/// Passages 2 m wide around a block, with niches and pillars at uneven places: 12 m x 8 m between the
/// middles.
inline lines_world::World ring_building() {
    lines_world::World world;
    grid_map_world::add_box(world, -1, -1, 13, 9);
    grid_map_world::add_box(world, 1, 1, 11, 7);
    for (const auto& [x, y] : {std::pair{2.1, -0.9},
                               {4.7, 0.9},
                               {8.2, -0.9},
                               {12.8, 2.3},
                               {11.1, 5.2},
                               {9.4, 8.9},
                               {6.3, 7.1},
                               {2.9, 8.9},
                               {-0.8, 6.4},
                               {0.9, 3.1}})
        grid_map_world::add_box(world, x - 0.3, y - 0.2, x + 0.3, y + 0.2);
    return world;
}

/// Scans at the true poses and the motions between them through mapping, to its end. `stamp(k)`: of scan k.
template <class Stamp>
void map_drive(grid_slam::GridSlam& slam, const lines_world::World& world, const std::vector<Pose2>& truth,
               const std::vector<grid_slam::Motion>& motions, const grid_map_world::Sensor& sensor,
               const Stamp& stamp, std::mt19937_64& random) {
    grid_slam::Motion before;  // the pose at the scan before, and how well it is known
    for (std::size_t k = 0; k < truth.size(); ++k) {
        if (const auto T_new_old = slam.advance()) before.T_before_now = *T_new_old * before.T_before_now;
        grid_slam::Prediction prediction;
        prediction.stamp_ns = stamp(k);
        prediction.duration_s = k == 0 ? 0 : 0.1;
        if (k > 0) prediction.motion = motions[k - 1];
        const grid_slam::Motion now = before * prediction.motion;
        prediction.T_map_base = now.T_before_now;
        prediction.covariance = now.covariance;
        const auto pose = slam.add(grid_map_world::scan_at(world, truth[k], sensor, random), prediction);
        before = {pose.T_map_base, pose.match.covariance};
    }
    slam.finish();
}

}  // namespace loopline::test
