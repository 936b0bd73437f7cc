#include "lidar_mapping/lidar_mapping_module.h"

#include <mrpt/obs/CObservationOdometry.h>

#include <algorithm>
#include <cmath>

#include "api/observation_class.h"
#include "api/pose_observation.h"
#include "api/sweep_classes.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LidarMappingModule, Module, loopline)

using namespace lidar_mapping;

namespace {

bool is_pose(const mrpt::obs::CObservation& observation) {
    return as<mrpt::obs::CObservationRobotPose>(&observation) != nullptr ||
           as<mrpt::obs::CObservationOdometry>(&observation) != nullptr;
}

}  // namespace

ModuleInfo LidarMappingModule::info() const {
    ModuleInfo info{
        "lidar_mapping",
        "Odometry and local map of a spinning lidar: each sweep is matched with the planes and edges "
        "of those before.",
        {},
        sweep_classes(),
        {"CObservationRobotPose"}};
    if (!odometry_settings_.label.empty())
        for (const char* pose : {"CObservationRobotPose", "CObservationOdometry"})
            info.uses.emplace_back(pose);
    return info;
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
        .text("odometry", odometry_settings_.label,
              "Label of the odometry that predicts each sweep's pose, such as lidar_odometry; empty: the "
              "velocity "
              "goes on as it was.")
        .integer("every_sweeps", every_sweeps_, {1, 1000},
                 "One of so many sweeps is matched with the map and added to it; between, the odometry "
                 "counts alone.")
        .real("odometry_sigma_m", odometry_settings_.sigma_m, {1e-4, 100},
              "Standard deviation of the odometry's way between two sweeps, beside what it says itself.")
        .angle("odometry_sigma_deg", odometry_settings_.sigma_rad, {1e-3, 180}, "And of the turn.")
        .real("cloud_sweep_s", cloud_sweep_.sweep_s, {0, 10},
              "Duration of a sweep whose points come without times.");
    return table;
}

void LidarMappingModule::start(const RunContext& context) {
    reader_ = std::make_unique<lidar::SpinningScanReader>(cloud_sweep_);
    mapping_ = std::make_unique<SweepMapping>(settings_, context.threads);
    odometry_ = std::make_unique<PublishedOdometry>(odometry_settings_);
    sweeps_.keep_in(context.scratch_folder, "lidar_mapping_sweeps");
}

void LidarMappingModule::process(const StreamItem& item, Publisher& publisher) {
    if (odometry_->take(*item.observation)) {
        if (waits_ && odometry_->reaches(now_.stamp_ns)) follow_waiting(publisher);
        return;
    }
    if (is_pose(*item.observation)) return;
    const std::string& label = item.observation->sensorLabel;
    if (!sensors_.empty() && std::find(sensors_.begin(), sensors_.end(), label) == sensors_.end()) return;
    if (waits_) follow_waiting(publisher);  // its pose has not come
    if (!reader_->read(*item.observation, now_.scan)) {
        ++unusable_;
        return;
    }
    now_.sequence = item.sequence;
    now_.stamp_ns = item.stamp_ns;
    now_.timestamp = item.observation->timestamp;
    waits_ = odometry_->wanted() && !odometry_->reaches(now_.stamp_ns);
    if (!waits_) follow(now_, publisher);
}

void LidarMappingModule::drain(Publisher& publisher) {
    if (waits_) follow_waiting(publisher);
}

void LidarMappingModule::follow_waiting(Publisher& publisher) {
    waits_ = false;
    follow(now_, publisher);
}

void LidarMappingModule::follow(const Waiting& now, Publisher& publisher) {
    const double middle_s = (now.scan.begin_s + now.scan.end_s) / 2;
    const Placed placed = place(now.scan, now.scan.stamp_ns + std::llround(1e9 * middle_s));
    // From the middle of the sweep to the stamp.
    const Pose3 T_map_base = placed.state.T_map_base * exp_se3(placed.state.velocity * -middle_s);
    Sweep sweep;
    sweep.sequence = now.sequence;
    sweep.stamp_ns = now.stamp_ns;
    sweep.T_map_base = Pose3Record(T_map_base);
    Eigen::Map<Matrix6d>(sweep.covariance.data()) = placed.covariance;
    sweeps_.push_back(sweep);
    publish(now, T_map_base, placed.covariance, publisher);
}

/// By the map, or between two sweeps that are matched with it by the odometry from the latest of them on.
LidarMappingModule::Placed LidarMappingModule::place(const lidar::SpinningScan& scan, StampNs middle_ns) {
    const auto latest_ns = mapping_->latest_middle_ns();
    std::optional<GivenMotion> given;
    if (latest_ns && odometry_->wanted()) given = odometry_->motion(*latest_ns, middle_ns);
    between_ = latest_ns && between_ + 1 < every_sweeps_ ? between_ + 1 : 0;
    if (between_ == 0) {
        const Registration& found = mapping_->add(scan, given ? &*given : nullptr);
        degenerate_ += found.degeneracy.free_directions > 0 ? 1 : 0;
        odometry_->forget_before(middle_ns);
        return {found.state, mapping_->covariance()};
    }
    const MotionState& last = mapping_->latest().state;
    const double duration_s = seconds_between(*latest_ns, middle_ns);
    const MotionState state = given ? predict(last, *given, duration_s, settings_.motion)
                                    : predict(last, duration_s, settings_.motion);
    return {state, mapping_->covariance() + state.covariance.topLeftCorner<6, 6>()};
}

void LidarMappingModule::publish(const Waiting& sweep, const Pose3& T_map_base, const Matrix6d& covariance,
                                 Publisher& publisher) const {
    publisher.publish(pose_observation(published_label, sweep.timestamp, T_map_base, covariance),
                      sweep.sequence);
}

void LidarMappingModule::finish(Results& results) {
    if (sweeps_.empty())
        results.refused =
            unusable_ > 0 ? "no sweep of the log has points that module lidar_mapping can use"
                          : "the log has no sweep of a spinning lidar, which module lidar_mapping is for; "
                            "see `loopline check` for what it has, and [lidar_mapping] sensors";
    for (const Sweep sweep : sweeps_)
        trajectory_.append(sweep.sequence, sweep.stamp_ns, sweep.T_map_base.pose(),
                           Matrix6d(Eigen::Map<const Matrix6d>(sweep.covariance.data())));
    results.metrics["map_cells"] = static_cast<std::int64_t>(mapping_->map().cells());
    results.metrics["scans_degenerate"] = degenerate_;
    if (unusable_ > 0) results.metrics["scans_unusable"] = unusable_;
    if (odometry_->wanted() && odometry_->taken() == 0)
        results.warnings.push_back("[lidar_mapping] odometry = " + odometry_settings_.label +
                                   ", but no pose with that label came; the velocity was taken to go on");
}

}  // namespace loopline
