/// Scenarios of datasets/ as scenes, without the way through a rawlog.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "config/scenario.h"
#include "simulation/encoders.h"
#include "simulation/segment.h"
#include "simulation/simulator_module.h"
#include "support/built_files.h"

namespace loopline::test {

inline std::string dataset(const std::string& name) {
    return source_folder() + "/datasets/" + name;
}

/// A scenario that only tests use: smaller than those of datasets/.
inline std::string test_scenario(const std::string& name) {
    return source_folder() + "/tests/support/" + name;
}

/// The scene that a scenario draws. Its sensors are those of a simulator of the test's own.
inline std::unique_ptr<simulation::Scene> scene_of(const std::string& scenario_file,
                                                   const std::vector<std::string>& overrides = {}) {
    WorldSimulator simulator;
    load_scenario(scenario_file, overrides, simulator);
    return simulation::make_scene(simulator.scenario());
}

/// When the vehicle is nearest to a place.
inline StampNs time_nearest_to(const simulation::Scene& scene, const Eigen::Vector2d& place_m) {
    double best_m = 1e9;
    StampNs best_ns = 0;
    for (StampNs t = 0; t <= scene.duration_ns(); t += 50'000'000)
        if (const double d = (scene.drive.motion.planar_pose_at(t).translation() - place_m).norm();
            d < best_m) {
            best_m = d;
            best_ns = t;
        }
    return best_ns;
}

/// The nearest that the middle of the vehicle's axle comes to anything that stands on the floor.
inline double clearance_m(const simulation::Scene& scene) {
    double least_m = 1e9;
    for (StampNs t = 0; t <= scene.duration_ns(); t += 150'000'000) {
        const Eigen::Vector2d at_m = scene.drive.motion.planar_pose_at(t).translation();
        for (const simulation::Wall& wall : scene.world.walls)
            if (wall.bottom_m < 1)
                least_m = std::min(least_m, simulation::distance_to_segment_m(at_m, wall.from_m, wall.to_m));
    }
    return least_m;
}

/// Where dead reckoning puts the scene's feature points: each through the poses of the moment when the
/// vehicle is nearest to it.
inline std::vector<double> dead_reckoning_errors_m(const simulation::Scene& scene,
                                                   const simulation::EncoderSettings& settings) {
    std::vector<double> errors_m;
    for (const auto& point : scene.world.points) {
        const StampNs nearest_ns = time_nearest_to(scene, point.position_m);
        simulation::Encoders encoders(settings, scene.drive);
        const Pose2 T_odom_base = encoders.read(nearest_ns).T_odom_base;
        const Pose2 T_map_base = scene.drive.motion.planar_pose_at(nearest_ns);
        errors_m.push_back(
            (T_odom_base * (T_map_base.inverse() * point.position_m) - point.position_m).norm());
    }
    return errors_m;
}

}  // namespace loopline::test
