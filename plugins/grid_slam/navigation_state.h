/// What of navigation goes into a checkpoint, class by class.
#pragma once

#include "api/state_archive.h"
#include "grid_slam/navigated_scans.h"

namespace loopline::grid_slam {

template <class Archive>
void fields(Archive& archive, Motion& motion) {
    archive(motion.T_before_now, motion.covariance);
}

template <class Archive>
void fields(Archive& archive, WheelNavigation& n) {
    archive(n.started_, n.stamp_ns_, n.T_odom_base_, n.T_map_base_, n.covariance_);
}

template <class Archive>
void fields(Archive& archive, InertialNavigation& n) {
    const auto sample = [](auto& a, inertial::ImuSample& s) {
        a(s.stamp_ns, s.omega_base_radps, s.specific_force_base_mps2);
    };
    archive(n.filter_, n.place_.p_base_imu_m, n.window_, n.alignment_status_, n.aligned_);
    archive.each(n.samples_, sample);
    archive.each(n.readings_, sample);
    bool latest = n.latest_.has_value();
    archive(latest);
    if (Archive::reading && latest) n.latest_.emplace();
    if (latest) sample(archive, *n.latest_);
    archive(n.first_ns_, n.scan_ns_, n.T_odom_base_, n.T_map_base_, n.T_before_now_, n.covariance_,
            n.refused_, n.backward_);
}

template <class Archive>
void fields(Archive& archive, NavigatedScans& scans) {
    archive.each(scans.waiting_, [](auto& a, auto& scan) {
        a(scan.sequence, scan.stamp_ns, scan.T_odom_base);
        if constexpr (Archive::reading)
            scan.observation = a.archive().template ReadObject<mrpt::obs::CObservation2DRangeScan>();
        else
            a.archive().WriteObject(*scan.observation);
    });
    if (scans.wheel_navigation_) archive(*scans.wheel_navigation_);
    if (scans.inertial_navigation_) archive(*scans.inertial_navigation_);
    archive(scans.without_odometry_, scans.without_imu_, scans.unusable_);
}

}  // namespace loopline::grid_slam
