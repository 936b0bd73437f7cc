#include "importers/carmen_objects.h"

#include <mrpt/obs/CActionRobotMovement2D.h>

namespace loopline::carmen {

mrpt::obs::CObservation2DRangeScan scan_observation(const Scan& scan, const ScanProperties& properties) {
    // MRPT's scans are symmetric about their sensor's x axis; a first beam elsewhere turns the sensor.
    Pose2 T_base_sensor = properties.T_base_laser;
    if (scan.configuration)
        T_base_sensor =
            T_base_sensor * Pose2{0, 0, scan.configuration->start_angle_rad + properties.aperture_rad / 2};
    mrpt::obs::CObservation2DRangeScan observation;
    observation.sensorLabel = name_of(scan.message);
    observation.timestamp = stamp_to_mrpt(properties.stamp_ns);
    observation.rightToLeft = true;
    observation.aperture = static_cast<float>(properties.aperture_rad);
    observation.maxRange = static_cast<float>(properties.max_range_m);
    observation.stdError = static_cast<float>(properties.sigma_range_m);
    observation.sensorPose =
        mrpt::poses::CPose3D(T_base_sensor.x_m, T_base_sensor.y_m, 0, T_base_sensor.phi_rad, 0, 0);
    observation.resizeScan(scan.ranges_m.size());
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
        const float range_m = scan.ranges_m[i];
        observation.setScanRange(i, range_m);
        observation.setScanRangeValidity(
            i, range_m > static_cast<float>(properties.min_range_m) && range_m < observation.maxRange);
    }
    return observation;
}

mrpt::obs::CObservationOdometry odometry_observation(const Pose2& T_odom_base, StampNs stamp_ns) {
    mrpt::obs::CObservationOdometry observation;
    observation.sensorLabel = "ODOM";
    observation.timestamp = stamp_to_mrpt(stamp_ns);
    observation.odometry = {T_odom_base.x_m, T_odom_base.y_m, T_odom_base.phi_rad};
    return observation;
}

mrpt::obs::CObservationOdometry odometry_observation(const Odometry& odometry, StampNs stamp_ns) {
    auto observation = odometry_observation(odometry.T_odom_base, stamp_ns);
    observation.hasVelocities = true;
    observation.velocityLocal = {odometry.speed_mps, 0, odometry.turn_rate_radps};
    return observation;
}

mrpt::obs::CActionCollection odometry_action(const Pose2& T_before_now, StampNs stamp_ns) {
    mrpt::obs::CActionRobotMovement2D movement;
    movement.timestamp = stamp_to_mrpt(stamp_ns);
    movement.computeFromOdometry({T_before_now.x_m, T_before_now.y_m, T_before_now.phi_rad}, {});
    mrpt::obs::CActionCollection collection;
    collection.insert(movement);
    return collection;
}

}  // namespace loopline::carmen
