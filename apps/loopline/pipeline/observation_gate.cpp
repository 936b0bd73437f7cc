#include "pipeline/observation_gate.h"

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationIMU.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/poses/CPose3D.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "api/observation_class.h"
#include "pipeline/raw_value.h"

namespace loopline {
namespace {

using namespace mrpt::obs;

constexpr double farthest_sensor_m = 1e3;    // from its vehicle's origin
constexpr double farthest_position_m = 1e8;  // twice round the Earth
constexpr float farthest_range_m = 1e5F;
constexpr std::size_t most_beams_of_scan = 200'000;

bool finite_within(double value, double bound) {
    return std::isfinite(value) && std::abs(value) <= bound;
}

/// Without a branch, so that compilers look at several beams at once. NaN is not.
bool is_possible(float range_m) {
    return (range_m > 0) & (range_m < farthest_range_m);
}

void invalidate_impossible_ranges(CObservation2DRangeScan& scan) {
    constexpr std::size_t block = 32;
    const std::size_t beams = scan.getScanSize();
    const float* const ranges_m = &scan.getScanRange(0);  // one checked call for all beams
    for (std::size_t first = 0; first < beams; first += block) {
        const std::size_t end = std::min(first + block, beams);
        std::uint32_t impossible = 0;
        for (std::size_t i = first; i < end; ++i) impossible += !is_possible(ranges_m[i]);
        for (std::size_t i = first; impossible > 0; ++i) {
            if (is_possible(ranges_m[i])) continue;
            scan.setScanRange(i, 0);
            scan.setScanRangeValidity(i, false);
            --impossible;
        }
    }
}

const char* refusal_of_scan(CObservation2DRangeScan& scan) {
    settle(scan.rightToLeft);
    if (scan.getScanSize() < 2) return "laser scans without beams";
    if (scan.getScanSize() > most_beams_of_scan) return "laser scans with more than 200000 beams";
    if (!std::isfinite(scan.aperture) || scan.aperture <= 0 ||
        scan.aperture > static_cast<float>(2 * M_PI + 1e-3))
        return "laser scans whose aperture is not within 0 .. 360 deg";
    if (!std::isfinite(scan.maxRange) || scan.maxRange <= 0)
        return "laser scans whose maximum range is not above 0";
    if (!finite_within(scan.deltaPitch, 2 * M_PI) || !std::isfinite(scan.stdError) || scan.stdError < 0 ||
        !std::isfinite(scan.beamAperture) || scan.beamAperture < 0)
        return "laser scans with impossible properties";
    invalidate_impossible_ranges(scan);
    return nullptr;
}

const char* refusal_of_odometry(CObservationOdometry& odometry) {
    settle(odometry.hasEncodersInfo);
    settle(odometry.hasVelocities);
    const bool sane = finite_within(odometry.odometry.x(), farthest_position_m) &&
                      finite_within(odometry.odometry.y(), farthest_position_m) &&
                      finite_within(odometry.odometry.phi(), 1e6) &&
                      (!odometry.hasVelocities || (finite_within(odometry.velocityLocal.vx, 1e4) &&
                                                   finite_within(odometry.velocityLocal.vy, 1e4) &&
                                                   finite_within(odometry.velocityLocal.omega, 1e4)));
    return sane ? nullptr : "odometry readings that are not finite or absurdly far";
}

const char* refusal_of_imu(CObservationIMU& imu) {
    for (bool& present : imu.dataIsPresent) settle(present);
    for (std::size_t i = 0; i < imu.rawMeasurements.size(); ++i)
        if (imu.dataIsPresent[i] && !std::isfinite(imu.rawMeasurements[i]))
            return "inertial readings that are not finite";
    return nullptr;
}

/// Numbers are looked at by those who use them (`gnss/gps_observation.h`): most messages are not for all.
void settle_flags(CObservationGPS& gps) {
    settle(gps.has_satellite_timestamp);
    const auto gga = gps.messages.find(mrpt::obs::gnss::NMEA_GGA);
    if (gga == gps.messages.end()) return;
    if (auto* const message = dynamic_cast<mrpt::obs::gnss::Message_NMEA_GGA*>(gga->second.get()))
        settle(message->fields.thereis_HDOP);
}

/// By its matrix: angles are computed only for those who need them.
bool is_sane(const mrpt::poses::CPose3D& T_base_sensor) {
    const auto& rotation = T_base_sensor.getRotationMatrix();
    return finite_within(T_base_sensor.x(), farthest_sensor_m) &&
           finite_within(T_base_sensor.y(), farthest_sensor_m) &&
           finite_within(T_base_sensor.z(), farthest_sensor_m) &&
           std::all_of(rotation.begin(), rotation.end(), [](double entry) { return std::isfinite(entry); });
}

const char* const insane_pose = "observations whose sensor pose is not finite or absurdly far";

const char* refusal_of_another(CObservation& observation) {
    mrpt::poses::CPose3D T_base_sensor;
    observation.getSensorPose(T_base_sensor);
    if (!is_sane(T_base_sensor)) return insane_pose;
    if (auto* imu = as<CObservationIMU>(&observation)) return refusal_of_imu(*imu);
    if (auto* gps = as<CObservationGPS>(&observation)) settle_flags(*gps);
    return nullptr;
}

}  // namespace

const char* refusal_of(CObservation& observation) {
    if (auto* scan = as<CObservation2DRangeScan>(&observation))
        return is_sane(scan->sensorPose) ? refusal_of_scan(*scan) : insane_pose;
    if (auto* odometry = as<CObservationOdometry>(&observation)) return refusal_of_odometry(*odometry);
    return refusal_of_another(observation);
}

}  // namespace loopline
