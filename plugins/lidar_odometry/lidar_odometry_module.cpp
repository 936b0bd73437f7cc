#include "lidar_odometry/lidar_odometry_module.h"

#include <algorithm>

#include "api/pose_observation.h"
#include "api/sweep_classes.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LidarOdometryModule, Module, loopline)

using namespace lidar_odometry;

namespace {

/// A covariance along the map's axes, along those of a vehicle there.
Matrix6d seen_from(const Pose3& T_map_base, const Matrix6d& covariance) {
    Matrix6d R = Matrix6d::Zero();
    R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() =
        T_map_base.rotation.conjugate().toRotationMatrix();
    return R * covariance * R.transpose();
}

}  // namespace

ModuleInfo LidarOdometryModule::info() const {
    return {"lidar_odometry",
            "Odometry of a spinning lidar from each sweep to the next, by edge points and planar points "
            "(LOAM).",
            {},
            sweep_classes(),
            {"CObservationRobotPose"}};
}

ParameterTable LidarOdometryModule::parameters() {
    auto& f = settings_.features;
    auto& m = settings_.matching;
    ParameterTable table("lidar_odometry", info().sentence);
    table
        .text(
            "sensor_label", sensor_label_,
            "Lidar whose sweeps are used; empty for the one that comes first in the log, others are ignored.")
        .real("min_range_m", f.min_range_m, {0, 100}, "Nearer returns are of the vehicle itself.")
        .real("max_range_m", f.max_range_m, {1, 1000}, "Farther returns are left out.")
        .integer("sectors", f.sectors, {1, 64}, "Equal parts of a ring, each with its own features.")
        .integer("edges_per_sector", f.edges_per_sector, {0, 1000},
                 "Edge points of a sector that are matched with the sweep before.")
        .integer("planes_per_sector", f.planes_per_sector, {0, 1000},
                 "Planar points of a sector that are matched with the sweep before.")
        .integer("edges_kept_per_sector", f.edges_kept_per_sector, {0, 1000},
                 "Edge points of a sector that the next sweep is matched with.")
        .real("min_edge_curvature", f.min_edge_curvature, {0, 10}, "An edge point's curvature is above.")
        .real("planar_spacing_m", f.planar_spacing_m, {0.01, 10},
              "Along a ring; a planar point is the mean of the returns over so long a way.")
        .real("max_distance_m", m.correspondences.max_distance_m, {0.01, 100},
              "Of a point to those of the sweep before that it is matched with.")
        .real("sigma_range_m", f.sigma_range_m, {1e-3, 1}, "Standard deviation of a range.")
        .real("sigma_surface_m", f.sigma_surface_m, {0, 1},
              "Roughness of surfaces and errors of beams, which no mean takes away.")
        .real("sigma_edge_m", f.sigma_edge_m, {0, 1},
              "How far beams that are wide and edges that are not sharp put an edge point off its edge.")
        .real("sigma_bend_per_m", m.correspondences.sigma_bend_per_m, {0, 1},
              "Curvature of surfaces that count as planes.")
        .real("loss_scale", m.loss_scale, {0.1, 100},
              "A point that is so many standard deviations off its line or plane counts half.")
        .real("sigma_degenerate_m", m.sigma_degenerate_m, {1e-3, 10},
              "A direction of motion that two sweeps hold no better than this is not observed.")
        .real("sigma_acceleration_mps2", settings_.sigma_acceleration_mps2, {0.01, 100},
              "How quickly the vehicle's speed changes.")
        .real("sigma_turn_radps2", settings_.sigma_turn_radps2, {0.01, 100}, "And its rates of turn.")
        .real("cloud_sweep_s", cloud_sweep_.sweep_s, {0, 10},
              "Duration of a sweep whose points come without times.");
    return table;
}

void LidarOdometryModule::start(const RunContext& context) {
    reader_ = std::make_unique<lidar::SpinningScanReader>(cloud_sweep_);
    odometry_ = std::make_unique<SweepOdometry>(settings_, context.threads);
    sweeps_.keep_in(context.scratch_folder, "lidar_odometry_sweeps");
}

void LidarOdometryModule::process(const StreamItem& item, Publisher& publisher) {
    const std::string& label = item.observation->sensorLabel;
    if (!sensor_label_.empty() && label != sensor_label_) return;
    if (!sweeps_.empty() && label != label_in_use_) {
        ++other_sensors_;
        return;
    }
    if (!reader_->read(*item.observation, scan_)) {
        ++unusable_;
        return;
    }
    if (!odometry_->add(scan_)) {
        ++backwards_;
        return;
    }
    label_in_use_ = label;
    if (!sweeps_.empty()) count(odometry_->latest().motion);
    publish(item, publisher);
}

void LidarOdometryModule::count(const MatchedMotion& motion) {
    lines_ += motion.lines;
    planes_ += motion.planes;
    unconverged_ += motion.converged ? 0 : 1;
    weakest_sigma_m_ = std::max(weakest_sigma_m_, motion.free.weakest_sigma_m);
    if (motion.free.count == 0) return;
    ++degenerate_;
    Eigen::Index most = 0;
    motion.free.weakest_moves_m.cwiseAbs().maxCoeff(&most);
    ++free_[static_cast<std::size_t>(most)];
}

void LidarOdometryModule::publish(const StreamItem& item, Publisher& publisher) {
    const OdometryStep& step = odometry_->latest();
    Sweep sweep;
    sweep.sequence = item.sequence;
    sweep.stamp_ns = item.stamp_ns;
    sweep.T_map_base = Pose3Record(step.T_map_base);
    Eigen::Map<Matrix6d>(sweep.covariance.data()) = step.covariance;
    const auto timestamp = item.observation->timestamp;
    publisher.publish(pose_observation(published_label, timestamp, step.T_map_base, step.covariance),
                      item.sequence);
    if (!sweeps_.empty())
        publisher.publish(pose_observation(motion_label, timestamp, T_map_last_.inverse() * step.T_map_base,
                                           seen_from(T_map_last_, step.motion_covariance)),
                          item.sequence);
    sweeps_.push_back(sweep);
    T_map_last_ = step.T_map_base;
}

void LidarOdometryModule::finish(Results& results) {
    if (sweeps_.empty())
        results.refused =
            unusable_ > 0 ? "no sweep of the log has points that module lidar_odometry can use"
                          : "the log has no sweep of a spinning lidar, which module lidar_odometry is for; "
                            "see `loopline check` for what it has, and [lidar_odometry] sensor_label";
    for (const Sweep sweep : sweeps_)
        trajectory_.append(sweep.sequence, sweep.stamp_ns, sweep.T_map_base.pose(),
                           Matrix6d(Eigen::Map<const Matrix6d>(sweep.covariance.data())));
    auto& metrics = results.metrics;
    const auto motions = static_cast<double>(std::max<std::size_t>(sweeps_.size(), 2) - 1);
    metrics["lidar_odometry_lines_mean"] = static_cast<double>(lines_) / motions;
    metrics["lidar_odometry_planes_mean"] = static_cast<double>(planes_) / motions;
    metrics["lidar_odometry_weakest_sigma_m"] = weakest_sigma_m_;
    metrics["lidar_odometry_degenerate"] = degenerate_;
    constexpr const char* names[6] = {"x", "y", "z", "roll", "pitch", "yaw"};
    for (std::size_t k = 0; k < free_.size(); ++k)
        if (free_[k] > 0) metrics[std::string("lidar_odometry_degenerate_") + names[k]] = free_[k];
    if (unconverged_ > 0) metrics["lidar_odometry_unconverged"] = unconverged_;
    if (unusable_ > 0) metrics["lidar_odometry_unusable"] = unusable_;
    if (backwards_ > 0) metrics["lidar_odometry_backwards"] = backwards_;
    if (other_sensors_ > 0) metrics["lidar_odometry_other_sensors"] = other_sensors_;
}

}  // namespace loopline
