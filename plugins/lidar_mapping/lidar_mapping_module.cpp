#include "lidar_mapping/lidar_mapping_module.h"

#include "api/dense_algebra.h"
#include "api/pose_observation.h"
#include "api/sweep_classes.h"
#include "inertial/pose_error.h"
#include "inertial/rotation_vector.h"
#include "lidar_mapping/matching_parameters.h"
#include "lidar_mapping/upright_walls.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(LidarMappingModule, Module, loopline)

using namespace lidar_mapping;

ModuleInfo LidarMappingModule::info() const {
    ModuleInfo info{
        "lidar_mapping",
        "Odometry and local map of a spinning lidar: each sweep is matched with the planes and edges "
        "of those before.",
        {},
        sweep_classes(),
        {"CObservationRobotPose"}};
    led_settings_.use(info);
    return info;
}

ParameterTable LidarMappingModule::parameters() {
    auto& s = settings_;
    ParameterTable table("lidar_mapping", info().sentence);
    led_settings_.declare_sensors(table);
    declare_range(table, s.sampling);
    table
        .real("map_voxel_m", s.map_voxel_m, {0.01, 10},
              "The map takes one return of a sweep from each cube of this edge.")
        .real("match_voxel_m", s.match_voxel_m, {0.01, 10}, "And one from each of these is matched with it.")
        .real("map_step_m", s.map_step_m, {0, 100}, "So far a sweep is from the last one that the map took.")
        .angle("map_turn_deg", s.map_turn_rad, {0, 180}, "Or so much it is turned.");
    declare_surfaces(table, s.map);
    table.real("keep_radius_m", s.map.keep_radius_m, {10, 10000}, "What is farther away is forgotten.");
    declare_registration(table, s);
    led_settings_.declare_odometry(table);
    table.integer("every_sweeps", every_sweeps_, {1, 1000},
                  "One of so many sweeps is matched with the map and added to it; between, the odometry "
                  "counts alone.");
    led_settings_.declare_cloud_sweep(table);
    return table;
}

void LidarMappingModule::start(const RunContext& context) {
    led_ = std::make_unique<LedSweeps>(led_settings_);
    mapping_ = std::make_unique<SweepMapping>(settings_, context.threads);
    sweeps_.keep_in(context.scratch_folder, "lidar_mapping_sweeps");
}

void LidarMappingModule::process(const StreamItem& item, Publisher& publisher) {
    led_->take(item, [&](const LedSweeps::Sweep& sweep) { follow(sweep, publisher); });
}

void LidarMappingModule::drain(Publisher& publisher) {
    led_->drain([&](const LedSweeps::Sweep& sweep) { follow(sweep, publisher); });
}

void LidarMappingModule::follow(const LedSweeps::Sweep& now, Publisher& publisher) {
    const Placed placed = place(now.scan, now.middle_ns());
    const Pose3 T_map_base = pose_near(placed.state, -now.middle_s());
    // About the vehicle where it was then: else what is added from pose to pose would hold the difference.
    const Matrix6d covariance =
        propagated(inertial::carried_along(T_map_base.translation_m - placed.state.T_map_base.translation_m),
                   placed.covariance);
    Sweep sweep;
    sweep.sequence = now.sequence;
    sweep.stamp_ns = now.stamp_ns;
    sweep.T_map_base = Pose3Record(T_map_base);
    Eigen::Map<Matrix6d>(sweep.covariance.data()) = covariance;
    look_for_upright(now, T_map_base, publisher);
    sweeps_.push_back(sweep);
    publish(now, T_map_base, covariance, publisher);
}

/// By the map, or between two sweeps that are matched with it by the odometry from the latest of them on.
LidarMappingModule::Placed LidarMappingModule::place(const lidar::SpinningScan& scan, StampNs middle_ns) {
    const auto latest_ns = mapping_->latest_middle_ns();
    const std::optional<GivenMotion> given = led_->motion(latest_ns, middle_ns);
    between_ = latest_ns && between_ + 1 < every_sweeps_ ? between_ + 1 : 0;
    if (between_ == 0) {
        const Registration& found = mapping_->add(scan, given ? &*given : nullptr);
        degenerate_ += found.degeneracy.free_directions > 0 ? 1 : 0;
        led_->forget_before(middle_ns);
        return {found.state, mapping_->covariance()};
    }
    const double duration_s = seconds_between(*latest_ns, middle_ns);
    const MotionState state = given ? mapping_->carried(*given, duration_s)
                                    : predict(mapping_->latest().state, duration_s, settings_.motion);
    return {state, mapping_->covariance() + state.covariance.topLeftCorner<6, 6>()};
}

/// Walls around are the same for a while.
void LidarMappingModule::look_for_upright(const LedSweeps::Sweep& sweep, const Pose3& T_map_base,
                                          Publisher& publisher) {
    constexpr double every_m = 50, again_m = 10, unknown = 1000;
    if (!sweeps_.empty())
        way_m_ += (T_map_base.translation_m - sweeps_.back().T_map_base.pose().translation_m).norm();
    if (way_m_ < upright_due_m_) return;
    const auto upright = upright_by_walls(mapping_->map());
    upright_due_m_ = way_m_ + (upright ? every_m : again_m);
    if (!upright) return;
    Pose3 T_level_map;
    T_level_map.rotation = inertial::upright(upright->up_map);
    Matrix6d covariance = unknown * unknown * Matrix6d::Identity();
    covariance.block<2, 2>(3, 3) = upright->covariance_rad2;
    publisher.publish(pose_observation(upright_label, sweep.timestamp, T_level_map, covariance),
                      sweep.sequence);
}

void LidarMappingModule::publish(const LedSweeps::Sweep& sweep, const Pose3& T_map_base,
                                 const Matrix6d& covariance, Publisher& publisher) const {
    publisher.publish(pose_observation(published_label, sweep.timestamp, T_map_base, covariance),
                      sweep.sequence);
}

void LidarMappingModule::finish(Results& results) {
    if (sweeps_.empty())
        results.refused =
            led_->unusable() > 0
                ? "no sweep of the log has points that module lidar_mapping can use"
                : "the log has no sweep of a spinning lidar, which module lidar_mapping is for; "
                  "see `loopline check` for what it has, and [lidar_mapping] sensors";
    for (const Sweep sweep : sweeps_)
        trajectory_.append(sweep.sequence, sweep.stamp_ns, sweep.T_map_base.pose(),
                           Matrix6d(Eigen::Map<const Matrix6d>(sweep.covariance.data())));
    results.metrics["map_cells"] = static_cast<std::int64_t>(mapping_->map().cells());
    results.metrics["scans_degenerate"] = degenerate_;
    if (led_->unusable() > 0) results.metrics["scans_unusable"] = led_->unusable();
    if (led_->odometry_never_came())
        results.warnings.push_back("[lidar_mapping] odometry = " + led_settings_.odometry.label +
                                   ", but no pose with that label came; the velocity was taken to go on");
}

}  // namespace loopline
