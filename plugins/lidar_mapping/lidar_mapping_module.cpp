#include "lidar_mapping/lidar_mapping_module.h"

#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LidarMappingModule, Module, loopline)

using namespace lidar_mapping;

ModuleInfo LidarMappingModule::info() const {
    return {"lidar_mapping",
            "Odometry and local map of a spinning lidar: each sweep is matched with the planes and edges of "
            "those before.",
            {},
            {"CObservationRotatingScan", "CObservationVelodyneScan", "CObservationPointCloud"},
            {"CObservationRobotPose"}};
}

ParameterTable LidarMappingModule::parameters() {
    auto& s = settings_;
    ParameterTable table("lidar_mapping", info().sentence);
    table.list("sensors", sensors_, "Labels of the lidars whose sweeps are used; empty for all.")
        .real("min_range_m", s.sampling.min_range_m, {0, 100}, "Nearer returns are of the vehicle itself.")
        .real("max_range_m", s.sampling.max_range_m, {1, 1000}, "Farther returns are left out.")
        .real("map_voxel_m", s.map_voxel_m, {0.01, 10},
              "The map takes one return of a sweep from each cube of this edge.")
        .real("match_voxel_m", s.match_voxel_m, {0.01, 10}, "And one from each of these is matched with it.")
        .real("map_step_m", s.map_step_m, {0, 100}, "So far a sweep is from the last one that the map took.")
        .angle("map_turn_deg", s.map_turn_rad, {0, 180}, "Or so much it is turned.")
        .real("cell_m", s.map.cell_m, {0.05, 10},
              "Edge of the map's smallest cubes, each with one plane or edge.")
        .integer("sizes", s.map.sizes, {1, 5}, "Sizes of cubes, each twice as large as the one before.")
        .real("keep_radius_m", s.map.keep_radius_m, {10, 10000}, "What is farther away is forgotten.")
        .real("sigma_range_m", s.map.sigma_range_m, {1e-3, 1}, "Standard deviation of a range.")
        .real("loss_scale", s.registration.loss_scale, {0.1, 100},
              "A return that is so many standard deviations off its surface counts half.")
        .real("sigma_degenerate_m", s.registration.sigma_degenerate_m, {1e-3, 10},
              "A direction of motion that a sweep holds no better than this is not observed.")
        .real("sigma_acceleration_mps2", s.motion.sigma_acceleration_mps2, {0.01, 100},
              "How quickly the vehicle's speed changes.")
        .real("sigma_turn_radps2", s.motion.sigma_turn_radps2, {0.01, 100}, "And its rates of turn.")
        .real("cloud_sweep_s", cloud_sweep_.sweep_s, {0, 10},
              "Duration of a sweep whose points come without times.");
    return table;
}

void LidarMappingModule::start(const RunContext& context) {
    reader_ = std::make_unique<lidar::SpinningScanReader>(cloud_sweep_);
    mapping_ = std::make_unique<SweepMapping>(settings_, context.threads);
    sweeps_.keep_in(context.scratch_folder, "lidar_mapping_sweeps");
}

void LidarMappingModule::process(const StreamItem& item, Publisher& publisher) {
    const std::string& label = item.observation->sensorLabel;
    if (!sensors_.empty() && std::find(sensors_.begin(), sensors_.end(), label) == sensors_.end()) return;
    if (!reader_->read(*item.observation, scan_)) {
        ++unusable_;
        return;
    }
    const Registration& found = mapping_->add(scan_);
    degenerate_ += found.degeneracy.free_directions > 0 ? 1 : 0;
    // From the middle of the sweep to the stamp.
    const double middle_s = (scan_.begin_s + scan_.end_s) / 2;
    const Pose3 T_map_base = found.state.T_map_base * exp_se3(found.state.velocity * -middle_s);
    const Matrix6d covariance = mapping_->covariance();
    Sweep sweep;
    sweep.sequence = item.sequence;
    sweep.stamp_ns = item.stamp_ns;
    const auto& t = T_map_base.translation_m;
    const auto& q = T_map_base.rotation;
    sweep.T_map_base = {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
    Eigen::Map<Matrix6d>(sweep.covariance.data()) = covariance;
    sweeps_.push_back(sweep);
    publish(item, T_map_base, covariance, publisher);
}

void LidarMappingModule::publish(const StreamItem& item, const Pose3& T_map_base, const Matrix6d& covariance,
                                 Publisher& publisher) const {
    auto published = mrpt::obs::CObservationRobotPose::Create();
    published->sensorLabel = published_label;
    published->timestamp = item.observation->timestamp;
    published->pose.mean = mrpt::poses::CPose3D(
        mrpt::math::CQuaternionDouble(T_map_base.rotation.w(), T_map_base.rotation.x(),
                                      T_map_base.rotation.y(), T_map_base.rotation.z()),
        T_map_base.translation_m.x(), T_map_base.translation_m.y(), T_map_base.translation_m.z());
    // Our (shift, turn about x, y, z) as MRPT's (x y z yaw pitch roll), for an attitude that is nearly level.
    constexpr int of_ours[6] = {0, 1, 2, 5, 4, 3};
    for (int row = 0; row < 6; ++row)
        for (int column = 0; column < 6; ++column)
            published->pose.cov(row, column) = covariance(of_ours[row], of_ours[column]);
    publisher.publish(published, item.sequence);
}

void LidarMappingModule::finish(Results& results) {
    if (sweeps_.empty())
        results.refused =
            unusable_ > 0 ? "no sweep of the log has points that module lidar_mapping can use"
                          : "the log has no sweep of a spinning lidar, which module lidar_mapping is for; "
                            "see `loopline check` for what it has, and [lidar_mapping] sensors";
    for (const Sweep sweep : sweeps_) {
        const auto& v = sweep.T_map_base;
        trajectory_.append(sweep.sequence, sweep.stamp_ns,
                           Pose3({v[0], v[1], v[2]}, Eigen::Quaterniond(v[6], v[3], v[4], v[5])),
                           Matrix6d(Eigen::Map<const Matrix6d>(sweep.covariance.data())));
    }
    results.metrics["map_cells"] = static_cast<std::int64_t>(mapping_->map().cells());
    results.metrics["scans_degenerate"] = degenerate_;
    if (unusable_ > 0) results.metrics["scans_unusable"] = unusable_;
}

}  // namespace loopline
