#include "simulation/spinning_lidar_sensor.h"

#include <mrpt/obs/CObservationRotatingScan.h>

#include <algorithm>

#include "lidar/beam_table.h"
#include "lidar/observation_scan.h"
#include "simulation/mesh/wall_mesh.h"
#include "simulation/sensor_pose.h"

namespace loopline::simulation {

ParameterTable SpinningLidarSensor::parameters() {
    return ParameterTable(
               name(),
               "A lidar on the roof that spins clockwise from behind, by the beams of a common model: "
               "CObservationRotatingScan, with the stamp of its first column.")
        .integer("beams", settings_.beams, {16, 64},
                 "Beams above each other: 16 (VLP-16), 32 (HDL-32E) or 64 (HDL-64E).")
        .integer("columns", settings_.columns, {16, 20000}, "Firings a turn, each at its own time.")
        .real("rate_hz", settings_.rate_hz, {0.1, 100}, "Turns a second.")
        .real("min_range_m", settings_.min_range_m, {0.1, 100}, "What is nearer gives no return.")
        .real("max_range_m", settings_.max_range_m, {1, 131}, "What is farther gives no return.")
        .real("sigma_range_m", settings_.sigma_range_m, {0, 10}, "Standard deviation of a range.")
        .real("dropouts", settings_.dropouts, {0, 1}, "Part of the beams that are lost wherever they point.")
        .real("least_reflectance", settings_.least_reflectance, {1e-6, 1},
              "What reflects less gives mostly no return from max_range_m; from nearer, by the square of the "
              "range, and "
              "by the cosine of incidence.")
        .real("x_m", x_m_, {-100, 100}, "Place on the vehicle, forward of its origin.")
        .real("y_m", y_m_, {-100, 100}, "To the left.")
        .real("z_m", z_m_, {-100, 100},
              "Above its origin, which is on the ground unless [path] gives the way.")
        .angle("yaw_deg", yaw_rad_, {-180, 180}, "Its heading on the vehicle.")
        .angle("pitch_deg", pitch_rad_, {-90, 90}, "How far it looks down.");
}

std::string SpinningLidarSensor::check() const {
    if (!lidar::table_of_beams(settings_.beams)) return "beams is none of 16, 32 and 64";
    if (settings_.min_range_m >= settings_.max_range_m) return "min_range_m is not below max_range_m";
    return {};
}

Pose3 SpinningLidarSensor::mount() const {
    return {{x_m_, y_m_, z_m_},
            Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad_, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(pitch_rad_, Eigen::Vector3d::UnitY()))};
}

void SpinningLidarSensor::start(const Scene& scene) {
    scene_ = &scene;
    model_.emplace(settings_, RandomStream(scene.seed, name()));
    index_ = returns_ = 0;
    if (!scene.landscape) walls_ = mesh_of(scene.world);
    caster_ = make_mesh_caster(scene.landscape ? scene.landscape->town.mesh : walls_);
}

mrpt::obs::CObservation::Ptr SpinningLidarSensor::next() {
    const StampNs time_ns = next_time_ns();
    const Pose3 T_base_lidar = mount();
    const auto T_map_lidar = [&](StampNs at_ns) {
        return scene_->drive.motion.pose_at(at_ns) * T_base_lidar;
    };
    MovingWorld moving;
    if (scene_->landscape) {
        const Traffic& traffic = scene_->landscape->traffic;
        moving.meshes = &traffic.meshes();
        if (!traffic.meshes().empty()) moving.at = [&traffic](StampNs at_ns) { return traffic.at(at_ns); };
    }
    const std::vector<std::uint16_t>& ranges = model_->scan(time_ns, T_map_lidar, *caster_, moving);
    returns_ += static_cast<std::int64_t>(ranges.size()) - std::count(ranges.begin(), ranges.end(), 0);
    auto observation =
        lidar::rotating_scan(model_->geometry(), lidar::table_of_beams(settings_.beams)->model, ranges);
    observation->sensorLabel = name();
    observation->timestamp = observation->originalReceivedTimestamp =
        stamp_to_mrpt(scene_->start_ns + time_ns);
    observation->sensorPose = mrpt_pose(T_base_lidar);
    observation->minRange = settings_.min_range_m;
    observation->maxRange = settings_.max_range_m;
    ++index_;
    return observation;
}

std::string SpinningLidarSensor::summary() const {
    return name() + ": " + std::to_string(returns_) + " returns in " + std::to_string(index_) + " scans.";
}

}  // namespace loopline::simulation
