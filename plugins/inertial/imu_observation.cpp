#include "inertial/imu_observation.h"

#include <array>

namespace loopline::inertial {
namespace {

using Channels = std::array<mrpt::obs::TIMUDataIndex, 3>;

std::optional<Eigen::Vector3d> vector_of(const mrpt::obs::CObservationIMU& observation,
                                         const Channels& channels) {
    Eigen::Vector3d v;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        if (!observation.has(channels[i])) return std::nullopt;
        v(static_cast<Eigen::Index>(i)) = observation.get(channels[i]);
    }
    return v;
}

}  // namespace

std::optional<ImuReading> reading_from_mrpt(const mrpt::obs::CObservationIMU& observation, StampNs stamp_ns) {
    using namespace mrpt::obs;
    const auto omega_imu_radps = vector_of(observation, {IMU_WX, IMU_WY, IMU_WZ});
    const auto force_imu_mps2 = vector_of(observation, {IMU_X_ACC, IMU_Y_ACC, IMU_Z_ACC});
    if (!omega_imu_radps || !force_imu_mps2) return std::nullopt;
    return ImuReading{stamp_ns, *omega_imu_radps, *force_imu_mps2,
                      observation.sensorPose.getRotationMatrix().asEigen()};
}

Eigen::Vector3d p_base_imu_m(const mrpt::obs::CObservationIMU& observation) {
    const auto& pose = observation.sensorPose;
    return {pose.x(), pose.y(), pose.z()};
}

}  // namespace loopline::inertial
