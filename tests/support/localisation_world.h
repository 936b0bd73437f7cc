/// Buildings of datasets/ with a map of them as map_server has it, and drives that are localised in it,
/// without the way through files.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include "grid_slam/grid_localisation.h"
#include "property/grid_map_world.h"
#include "support/grid_slam_drive.h"
#include "support/simulated_scene.h"

namespace loopline::test {

constexpr double laser_height_m = 0.45;

/// The walls at the height of the laser.
inline lines_world::World walls_of(const simulation::Scene& scene) {
    lines_world::World world;
    for (const auto& wall : scene.world.walls)
        if (wall.bottom_m <= laser_height_m && wall.top_m >= laser_height_m)
            world.walls.push_back({wall.from_m, wall.to_m});
    return world;
}

/// True poses at equal times, `from_m` to `to_m` along the way.
inline std::vector<Pose2> poses_along(const simulation::Scene& scene, double from_m, double to_m,
                                      double every_s) {
    std::vector<Pose2> poses;
    const auto step_ns = static_cast<StampNs>(every_s * 1e9);
    double way_m = 0;
    Pose2 before = scene.drive.motion.planar_pose_at(0);
    for (StampNs t = 0; t <= scene.duration_ns() && way_m <= to_m; t += step_ns) {
        const Pose2 now = scene.drive.motion.planar_pose_at(t);
        way_m += (now.translation() - before.translation()).norm();
        before = now;
        if (way_m > 0 && way_m >= from_m) poses.push_back(now);
    }
    return poses;
}

const grid_map_world::Sensor map_laser{181, 1.5 * M_PI, {0.25, 0, 0}, 0.01, 30};

/// Cells that beams ended in or passed, seen from the poses. The picture lies at `T_map_picture`.
inline MapServerMap map_seen_from(const lines_world::World& world, const std::vector<Pose2>& poses,
                                  double resolution_m, const Pose2& T_map_picture, std::size_t width,
                                  std::size_t height) {
    MapServerMap map;
    map.width = width;
    map.height = height;
    map.resolution_m = resolution_m;
    map.T_map_picture = T_map_picture;
    map.cells.assign(width * height, MapCell::unknown);
    map.free_probability.assign(width * height, 0.5F);
    const Pose2 T_picture_map = T_map_picture.inverse();
    const auto mark = [&](const Eigen::Vector2d& p_map_m, MapCell as) {
        const Eigen::Vector2d p = T_picture_map * p_map_m / resolution_m;
        if (p.x() < 0 || p.y() < 0 || p.x() >= static_cast<double>(width) ||
            p.y() >= static_cast<double>(height))
            return;
        MapCell& cell =
            map.cells[map.index(static_cast<std::size_t>(p.x()), static_cast<std::size_t>(p.y()))];
        if (cell != MapCell::occupied) cell = as;
    };
    std::mt19937_64 random(1);
    auto exact = map_laser;
    exact.sigma_m = 0;
    for (const Pose2& T : poses) {
        const PlanarScan scan = grid_map_world::scan_at(world, T, exact, random);
        const Pose2 T_map_sensor = T * exact.T_base_sensor;
        for (std::size_t beam = 0; beam < scan.size(); ++beam) {
            if (!scan.has_return(beam)) continue;
            const Eigen::Vector2d end_m = scan.point_sensor_m(beam);
            mark(T_map_sensor * end_m, MapCell::occupied);
            const double range_m = end_m.norm();
            for (double r = 0; r < range_m - 1.5 * resolution_m; r += 0.7 * resolution_m)
                mark(T_map_sensor * Eigen::Vector2d(end_m * (r / range_m)), MapCell::free);
        }
    }
    return map;
}

/// A drive localised scan by scan, with wheels as `noisy_motions` has them.
struct LocalisedDrive {
    std::vector<Pose2> truth;
    std::vector<bool> known;  ///< at its time
    std::vector<Pose2> online;
    std::vector<Pose2> final_poses;
    bool ever_known = false;
    std::size_t known_from = 0;
    double known_after_m = 0, share_matched = 0;
    std::vector<grid_slam::LostStretch> lost;
    std::string why_not;

    double error_m(std::size_t k) const {
        return (final_poses[k].translation() - truth[k].translation()).norm();
    }
    double rmse_m() const {
        double squares = 0;
        for (std::size_t k = 0; k < truth.size(); ++k) squares += error_m(k) * error_m(k);
        return std::sqrt(squares / static_cast<double>(truth.size()));
    }
};

template <class SeenWorld>
LocalisedDrive localise(const grid_slam::FrozenMap& map, const grid_slam::LocalisationSettings& settings,
                        const std::vector<Pose2>& truth, std::uint64_t seed, const SeenWorld& world_at) {
    using namespace grid_slam;
    constexpr double deg = M_PI / 180;
    std::mt19937_64 random(seed);
    const auto motions = noisy_motions(truth, {0.01, 0.01, 0.3 * deg}, random);
    GridLocalisation localisation(settings, map);
    LocalisedDrive drive;
    drive.truth = truth;
    Motion before{localisation.start(), Eigen::Matrix3d::Zero()};
    for (std::size_t k = 0; k < truth.size(); ++k) {
        Prediction prediction;
        prediction.stamp_ns = static_cast<StampNs>(k) * 200'000'000;
        prediction.duration_s = k == 0 ? 0 : 0.2;
        if (k > 0) prediction.motion = motions[k - 1];
        const Motion now = before * prediction.motion;
        prediction.T_map_base = now.T_before_now;
        prediction.covariance = now.covariance;
        const auto scan = grid_map_world::scan_at(world_at(k), truth[k], map_laser, random);
        const LocalisedScan result = localisation.add(scan, prediction, {});
        before = {result.match.T_map_base, result.match.covariance};
        drive.known.push_back(result.known);
        drive.online.push_back(result.T_map_base);
    }
    drive.final_poses = localisation.poses();
    drive.ever_known = localisation.ever_known();
    drive.known_from = localisation.known_from();
    drive.known_after_m = localisation.known_after_m();
    drive.share_matched = static_cast<double>(localisation.matched()) / static_cast<double>(truth.size());
    drive.lost = localisation.lost();
    drive.why_not = localisation.search().latest().reason;
    return drive;
}

}  // namespace loopline::test
