#include "lidar_mapping/lidar_mapping_module.h"

#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>


namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LidarMappingModule, Module, loopline)

using namespace lidar_mapping;

ModuleInfo LidarMappingModule::info() const {
    return {"lidar_mapping",
            "Odometry and local map of a spinning lidar: each sweep is matched with the planes and edges of those before.",
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
        .real("cell_m", s.map.cell_m, {0.05, 10}, "Edge of the map's smallest cubes, each with one plane or edge.")
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
}

void LidarMappingModule::process(const StreamItem& item, Publisher& publisher) {
    const std::string& label = item.observation->sensorLabel;
    if (!sensors_.empty() && std::find(sensors_.begin(), sensors_.end(), label) == sensors_.end()) return;
    if (!reader_->read(*item.observation, scan_)) {
        ++unusable_;
        return;
    }
    const Registration& found = mapping_->add(scan_);
    if (getenv("DBG")) { auto& t=found.state.T_map_base.translation_m; auto &v=found.state.velocity; auto &g=found.degeneracy; fprintf(stderr,"DBG %zu p %.3f %.3f %.3f v %.3f %.3f %.3f w %.4f %.4f %.4f fit %.2f rms %.2f used %d it %d conv %d cells %zu pts %zu free %d weak %.3f (%.2f %.2f %.2f)\n",trajectory_.size(),t.x(),t.y(),t.z(),v.shift_m.x(),v.shift_m.y(),v.shift_m.z(),v.turn_rad.x(),v.turn_rad.y(),v.turn_rad.z(),found.fit,found.rms_sigmas,found.used,found.iterations,found.converged,mapping_->map().cells(),scan_.points.size(),g.free_directions,g.weakest_sigma_m,g.weakest[0],g.weakest[1],g.weakest[2]); }
    const double middle_s = (scan_.begin_s + scan_.end_s) / 2;
    const Pose3 T_map_base = found.state.T_map_base * exp_se3(found.state.velocity * -middle_s);
    const Matrix6d covariance = found.state.covariance.topLeftCorner<6, 6>();
    trajectory_.append(item.sequence, item.stamp_ns, T_map_base, covariance);
    auto published = mrpt::obs::CObservationRobotPose::Create();
    published->sensorLabel = published_label;
    published->timestamp = item.observation->timestamp;
    const auto& q = T_map_base.rotation;
    const auto& t = T_map_base.translation_m;
    published->pose.mean =
        mrpt::poses::CPose3D(mrpt::math::CQuaternionDouble(q.w(), q.x(), q.y(), q.z()), t.x(), t.y(), t.z());
    publisher.publish(published, item.sequence);
}

void LidarMappingModule::finish(Results& results) {
    results.metrics["map_cells"] = static_cast<std::int64_t>(mapping_->map().cells());
    if (unusable_ > 0) results.metrics["scans_unusable"] = unusable_;
}

}  // namespace loopline
