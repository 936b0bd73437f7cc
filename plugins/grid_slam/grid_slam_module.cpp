#include "grid_slam/grid_slam_module.h"

#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "api/observation_class.h"
#include "inertial/imu_observation.h"
#include "odometry/twist2.h"

namespace loopline {
IMPLEMENTS_MRPT_OBJECT(GridSlamModule, Module, loopline)

namespace {

using namespace grid_slam;

mrpt::obs::CObservationRobotPose::Ptr pose_observation(const Pose2& T_map_base,
                                                       const Eigen::Matrix3d& covariance) {
    auto observation = mrpt::obs::CObservationRobotPose::Create();
    observation->sensorLabel = GridSlamModule::published_label;
    observation->pose.mean =
        mrpt::poses::CPose3D(T_map_base.x_m, T_map_base.y_m, 0, T_map_base.phi_rad, 0, 0);
    observation->pose.cov.setZero();
    constexpr int index[3] = {0, 1, 3};  // x, y, yaw of MRPT's (x y z yaw pitch roll)
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            observation->pose.cov(index[row], index[column]) = covariance(row, column);
    return observation;
}

std::vector<std::vector<Eigen::Vector2f>> points_of(const std::vector<grid_map::Frame>& frames) {
    std::vector<std::vector<Eigen::Vector2f>> points_m(frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        points_m[i].reserve(frames[i].points.size());
        for (const grid_map::SurfacePoint& point : frames[i].points) points_m[i].push_back(point.p_base_m);
    }
    return points_m;
}

}  // namespace

ModuleInfo GridSlamModule::info() const {
    ModuleInfo info{
        "grid_slam",
        "Maps with a planar laser on a grid, finds loops of the path by itself and corrects them.",
        {"CObservation2DRangeScan"},
        {},
        {"CObservationRobotPose"}};
    (source_ == Source::imu ? info.uses : info.needs).push_back("CObservationOdometry");
    (source_ == Source::wheel ? info.uses : info.needs).push_back("CObservationIMU");
    return info;
}

void GridSlamModule::start(const RunContext&) {
    settings_.loops.cell_m = settings_.cell_m;
    settings_.loops.refinement = settings_.forward.refinement;
    settings_.links.refinement = settings_.forward.refinement;
    settings_.links.refinement.iterations = 15;
    settings_.links.refinement.give_up_fit = 0.3;
    if (!loops_) settings_.loops.every_m = std::numeric_limits<double>::infinity();
    inertial_.wheels = source_ == Source::imu_wheel;
    inertial_.keep_readings = settings_.weights != Weights::joint;
    settings_.decisions.named = named_loops_from_text(named_loops_);
    settings_.decisions.refused = refusals_from_text(refused_loops_);
    settings_.decisions.without_search = intervals_from_text(without_search_);
    slam_ = std::make_unique<GridSlam>(settings_);
    if (source_ == Source::wheel)
        wheel_navigation_ = std::make_unique<WheelNavigation>(wheels_);
    else
        inertial_navigation_ = std::make_unique<InertialNavigation>(inertial_);
    if (inertial_navigation_ != nullptr)
        reverse_navigation_ = std::make_unique<InertialReverse>(*inertial_navigation_, slam_->map());
    slam_->set_reverse_navigation(reverse_navigation_.get());
}

bool GridSlamModule::is_wanted(const std::string& label) const {
    return sensors_.empty() || std::find(sensors_.begin(), sensors_.end(), label) != sensors_.end();
}

void GridSlamModule::take_odometry(const StreamItem& item) {
    const auto& odometry = static_cast<const mrpt::obs::CObservationOdometry&>(*item.observation);
    if (odometry.sensorLabel != odometry_label) return;
    for (Scan& scan : waiting_) {
        // What a module publishes carries the sequence of its scan; what a log holds has its own.
        const bool same = item.published ? scan.sequence == item.sequence
                                         : scan.stamp_ns == item.stamp_ns && !scan.T_odom_base;
        if (!same) continue;
        scan.T_odom_base =
            Pose2{odometry.odometry.x(), odometry.odometry.y(), wrap_to_pi(odometry.odometry.phi())};
        return;
    }
}

void GridSlamModule::take_imu(const mrpt::obs::CObservationIMU& observation, StampNs stamp_ns) {
    if (!imu_label_.empty() && observation.sensorLabel != imu_label_) return;
    if (const auto reading = inertial::reading_from_mrpt(observation, stamp_ns))
        inertial_navigation_->add(reading->along_base(), inertial::p_base_imu_m(observation));
}

/// Whether all that navigation needs up to a scan is there, or will not come any more.
bool GridSlamModule::is_ready(const Scan& scan) const {
    constexpr double longest_wait_s = 1;
    if (seconds_between(scan.stamp_ns, waiting_.back().stamp_ns) > longest_wait_s) return true;
    if (source_ != Source::wheel && !inertial_navigation_->reaches(scan.stamp_ns)) return false;
    if (source_ == Source::imu || scan.T_odom_base) return true;
    return std::any_of(waiting_.begin(), waiting_.end(),
                       [](const Scan& later) { return later.T_odom_base.has_value(); });
}

void GridSlamModule::process(const StreamItem& item, Publisher& publisher) {
    if (auto scan = as<const mrpt::obs::CObservation2DRangeScan>(item.observation)) {
        if (is_wanted(scan->sensorLabel))
            waiting_.push_back({item.sequence, item.stamp_ns, std::move(scan), std::nullopt});
    } else if (as<const mrpt::obs::CObservationOdometry>(item.observation.get()) != nullptr) {
        take_odometry(item);
    } else if (inertial_navigation_ != nullptr) {
        if (const auto* imu = as<const mrpt::obs::CObservationIMU>(item.observation.get()))
            take_imu(*imu, item.stamp_ns);
    }
    while (!waiting_.empty() && is_ready(waiting_.front())) {
        estimate(waiting_.front(), publisher);
        waiting_.pop_front();
        if (slam_->loop_at_hand()) break;  // a state is kept in between
    }
}

void GridSlamModule::drain(Publisher& publisher) {
    for (const Scan& scan : waiting_) estimate(scan, publisher);
    waiting_.clear();
}

Prediction GridSlamModule::predict(const Scan& scan) {
    if (source_ != Source::imu && !scan.T_odom_base) ++without_odometry_;
    if (wheel_navigation_ != nullptr) return wheel_navigation_->predict(scan.stamp_ns, scan.T_odom_base);
    if (!inertial_navigation_->reaches(scan.stamp_ns)) ++without_imu_;
    return inertial_navigation_->predict(scan.stamp_ns, scan.T_odom_base);
}

void GridSlamModule::move(const Pose2& T_new_old) {
    if (wheel_navigation_ != nullptr) wheel_navigation_->move(T_new_old);
    if (inertial_navigation_ != nullptr) inertial_navigation_->move(T_new_old);
}

/// As the vehicle moved since the scan before.
grid_map::SweepMotion GridSlamModule::sweep(const Prediction& prediction) const {
    if (scan_duration_s_ == 0 || !(prediction.duration_s > 0)) return {};
    const Twist2 twist = log_se2(prediction.motion.T_before_now) * (scan_duration_s_ / prediction.duration_s);
    return {twist.forward_m, twist.left_m, twist.turn_rad};
}

void GridSlamModule::estimate(const Scan& scan, Publisher& publisher) {
    if (!to_planar_scan(*scan.observation, beams_)) {
        ++unusable_;
        return;
    }
    if (const auto T_new_old = slam_->advance()) move(*T_new_old);
    const Prediction prediction = predict(scan);
    const ScanPose pose = slam_->add(beams_, prediction, sweep(prediction));
    if (wheel_navigation_ != nullptr) wheel_navigation_->update(scan.stamp_ns, scan.T_odom_base, pose.match);
    if (inertial_navigation_ != nullptr) inertial_navigation_->update(pose.match);
    online_.push_back({scan.sequence, scan.stamp_ns, pose.T_map_base});
    const auto published = pose_observation(pose.T_map_base, pose.match.covariance);
    published->timestamp = scan.observation->timestamp;
    publisher.publish(published, scan.sequence);
}

void GridSlamModule::lay_out_trajectory() {
    std::vector<Pose2> poses;
    std::vector<Eigen::Matrix3d> covariances;
    slam_->path(poses, covariances);
    trajectory_.reserve(online_.size());
    std::size_t k = 0;
    for (const OnlinePose& online : online_)
        trajectory_.append(online.sequence, online.stamp_ns, Pose3(online.T_map_base),
                           PoseCovariance::planar(covariances[k++]));
    for (k = 0; k < poses.size(); ++k)
        trajectory_.revise(k, Pose3(poses[k]), PoseCovariance::planar(covariances[k]));
    trajectory_.finish_revision();
}

void GridSlamModule::report_loops(Results& results) const {
    std::int64_t accepted = 0, refused = 0;
    std::vector<LoopDecision> never_tried;
    for (const auto& [named, reason] : slam_->decisions().untried()) {
        LoopDecision loop;
        loop.stamp_ns = named->stamp_ns;
        loop.old_stamp_ns = named->old_stamp_ns;
        loop.reason = reason;
        ++refused;
        never_tried.push_back(std::move(loop));
    }
    for (const LoopRecord& record : slam_->loops()) {
        LoopDecision loop;
        loop.stamp_ns = online_[slam_->map().scans[record.frame]].stamp_ns;
        loop.old_stamp_ns = online_[slam_->map().scans[record.old_frame]].stamp_ns;
        loop.way_m = record.way_m;
        loop.score = record.likelihood;
        loop.rival_score = record.rival;
        loop.shift_m = record.shift.head<2>().norm();
        loop.shift_rad = record.shift.z();
        loop.sigma_m = record.sigma_m;
        loop.sigma_rad = record.sigma_rad;
        loop.accepted = record.decision == LoopRecord::Decision::accepted;
        loop.waits = record.decision == LoopRecord::Decision::waits;
        loop.reason = record.reason;
        (loop.accepted ? accepted : refused) += record.decision == LoopRecord::Decision::waits ? 0 : 1;
        results.loops.push_back(std::move(loop));
    }
    results.loops.insert(results.loops.end(), never_tried.begin(), never_tried.end());
    results.metrics["loops_found"] = accepted;
    results.metrics["loops_refused"] = refused;
    for (const Correction& c : slam_->corrections())
        if (!c.before.empty())
            results.corrections.push_back({c.stamp_ns, c.old_frame, c.frame, c.T_before_after, c.before,
                                           c.after, c.reverse_first, c.reverse});
    PoseGraph graph;
    graph.poses = slam_->map().poses;
    for (const Constraint& c : slam_->constraints())
        graph.constraints.push_back({c.from, c.to, c.T_from_to, c.information});
    results.pose_graph = std::move(graph);
}

void GridSlamModule::finish(Results& results) {
    slam_->finish();
    lay_out_trajectory();
    report_loops(results);
    if (!results.corrections.empty()) results.frame_points_base_m = points_of(slam_->map().frames);
    auto& metrics = results.metrics;
    metrics["corrections"] = static_cast<std::int64_t>(slam_->corrections().size());
    metrics["map_frames"] = static_cast<std::int64_t>(slam_->map().size());
    metrics["constraints"] = static_cast<std::int64_t>(slam_->constraints().size());
    metrics["scans_unmatched"] = static_cast<std::int64_t>(slam_->unmatched());
    metrics["scans_degenerate"] = static_cast<std::int64_t>(slam_->degenerate());
    if (inertial_navigation_ != nullptr) {
        metrics["imu_aligned"] =
            inertial_navigation_->alignment_status() == inertial::AlignmentStatus::aligned;
        metrics["imu_readings_backward"] = inertial_navigation_->backward();
        metrics["wheel_speeds_refused"] = inertial_navigation_->refused();
        if (without_imu_ > 0) metrics["scans_without_imu"] = without_imu_;
    }
    if (without_odometry_ > 0) metrics["scans_without_odometry"] = without_odometry_;
    if (unusable_ > 0) metrics["scans_unusable"] = unusable_;
}

}  // namespace loopline
