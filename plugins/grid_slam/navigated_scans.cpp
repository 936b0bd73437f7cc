#include "grid_slam/navigated_scans.h"

#include <mrpt/obs/CObservationOdometry.h>

#include <algorithm>

#include "api/observation_class.h"
#include "api/twist2.h"
#include "inertial/imu_observation.h"

namespace loopline::grid_slam {

void NavigatedScans::add_needs(ModuleInfo& info) const {
    (source_ == Source::imu ? info.uses : info.needs).push_back("CObservationOdometry");
    (source_ == Source::wheel ? info.uses : info.needs).push_back("CObservationIMU");
}

void fit_surfaces_to_noise(grid_map::FrameSettings& frame, double sigma_return_m) {
    frame.surface_half_m = 5 * sigma_return_m;
    frame.sigma_surface_m = 1.5 * sigma_return_m;
}

void NavigatedScans::start(bool keep_readings) {
    settings_.wheels = source_ == Source::imu_wheel;
    settings_.keep_readings = keep_readings;
    if (source_ == Source::wheel)
        wheel_navigation_ = std::make_unique<WheelNavigation>(wheels_);
    else
        inertial_navigation_ = std::make_unique<InertialNavigation>(settings_);
}

bool NavigatedScans::is_wanted(const std::string& label) const {
    return sensors_.empty() || std::find(sensors_.begin(), sensors_.end(), label) != sensors_.end();
}

void NavigatedScans::take_odometry(const StreamItem& item) {
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

void NavigatedScans::take_imu(const mrpt::obs::CObservationIMU& observation, StampNs stamp_ns) {
    if (!imu_label_.empty() && observation.sensorLabel != imu_label_) return;
    if (const auto reading = inertial::reading_from_mrpt(observation, stamp_ns))
        inertial_navigation_->add(reading->along_base(), inertial::p_base_imu_m(observation));
}

/// Whether all that navigation needs up to a scan is there, or will not come any more.
bool NavigatedScans::is_ready(const Scan& scan) const {
    constexpr double longest_wait_s = 1;
    if (seconds_between(scan.stamp_ns, waiting_.back().stamp_ns) > longest_wait_s) return true;
    if (source_ != Source::wheel && !inertial_navigation_->reaches(scan.stamp_ns)) return false;
    if (source_ == Source::imu || scan.T_odom_base) return true;
    return std::any_of(waiting_.begin(), waiting_.end(),
                       [](const Scan& later) { return later.T_odom_base.has_value(); });
}

void NavigatedScans::take(const StreamItem& item) {
    if (auto scan = as<const mrpt::obs::CObservation2DRangeScan>(item.observation)) {
        if (is_wanted(scan->sensorLabel))
            waiting_.push_back({item.sequence, item.stamp_ns, std::move(scan), std::nullopt});
    } else if (as<const mrpt::obs::CObservationOdometry>(item.observation.get()) != nullptr) {
        take_odometry(item);
    } else if (inertial_navigation_ != nullptr) {
        if (const auto* imu = as<const mrpt::obs::CObservationIMU>(item.observation.get()))
            take_imu(*imu, item.stamp_ns);
    }
}

const PlanarScan* NavigatedScans::beams(const Scan& scan) {
    if (to_planar_scan(*scan.observation, beams_)) return &beams_;
    ++unusable_;
    return nullptr;
}

Prediction NavigatedScans::predict(const Scan& scan) {
    if (source_ != Source::imu && !scan.T_odom_base) ++without_odometry_;
    if (wheel_navigation_ != nullptr) return wheel_navigation_->predict(scan.stamp_ns, scan.T_odom_base);
    if (!inertial_navigation_->reaches(scan.stamp_ns)) ++without_imu_;
    return inertial_navigation_->predict(scan.stamp_ns, scan.T_odom_base);
}

grid_map::SweepMotion NavigatedScans::sweep(const Prediction& prediction) const {
    if (scan_duration_s_ == 0 || !(prediction.duration_s > 0)) return {};
    const Twist2 twist = log_se2(prediction.motion.T_before_now) * (scan_duration_s_ / prediction.duration_s);
    return {twist.forward_m, twist.left_m, twist.turn_rad};
}

void NavigatedScans::update(const Scan& scan, const ForwardMatch& match) {
    if (wheel_navigation_ != nullptr) wheel_navigation_->update(scan.stamp_ns, scan.T_odom_base, match);
    if (inertial_navigation_ != nullptr) inertial_navigation_->update(match);
}

void NavigatedScans::move(const Pose2& T_new_old) {
    if (wheel_navigation_ != nullptr) wheel_navigation_->move(T_new_old);
    if (inertial_navigation_ != nullptr) inertial_navigation_->move(T_new_old);
}

void NavigatedScans::report(std::map<std::string, MetricValue>& metrics) const {
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

mrpt::obs::CObservationRobotPose::Ptr pose_observation(const std::string& label, const Pose2& T_map_base,
                                                       const Eigen::Matrix3d& covariance) {
    auto observation = mrpt::obs::CObservationRobotPose::Create();
    observation->sensorLabel = label;
    observation->pose.mean =
        mrpt::poses::CPose3D(T_map_base.x_m, T_map_base.y_m, 0, T_map_base.phi_rad, 0, 0);
    observation->pose.cov.setZero();
    constexpr int index[3] = {0, 1, 3};  // x, y, yaw of MRPT's (x y z yaw pitch roll)
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            observation->pose.cov(index[row], index[column]) = covariance(row, column);
    return observation;
}

}  // namespace loopline::grid_slam
