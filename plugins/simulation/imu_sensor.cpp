#include "simulation/imu_sensor.h"

#include <mrpt/obs/CObservationIMU.h>

#include <cmath>

#include "simulation/sensor_pose.h"

namespace loopline::simulation {
namespace {

TruthRow bias_row(const char* kind, int number, const Eigen::Vector3d& gyro, const Eigen::Vector3d& force) {
    return {kind, number, {gyro.x(), gyro.y(), gyro.z(), force.x(), force.y(), force.z()}};
}

}  // namespace

ParameterTable ImuSensor::parameters() {
    TriadSettings &g = imu_.gyro, &a = imu_.accelerometer;
    return ParameterTable(
               "imu",
               "A MEMS inertial measurement unit: CObservationIMU, with rates and specific forces that "
               "are means over the sample interval about the stamp.")
        .real("rate_hz", imu_.rate_hz, {1, 2000}, "Samples a second.")
        .angle(
            "gyro_noise_deg", g.noise, {0, 10},
            "Noise of the gyros: standard deviation of the angle that it adds up to in 1 s (deg/s/sqrt(Hz)).")
        .angle("gyro_bias_dps", g.bias, {0, 10}, "Standard deviation of the bias, drawn for each axis.")
        .angle("gyro_drift_dps", g.drift, {0, 10},
               "Standard deviation of how the bias wanders during the drive.")
        .real("gyro_drift_s", g.drift_s, {1, 1e6}, "Correlation time of that.")
        .real("gyro_scale_error", g.scale_error, {0, 0.1},
              "Standard deviation of the scale factor's error, drawn for each axis.")
        .angle("gyro_resolution_dps", g.resolution, {0, 10}, "Rates are multiples of this; 0: any number.")
        .real("accelerometer_noise_mps", a.noise, {0, 1},
              "Noise of the accelerometers: standard deviation of the speed that it adds up to in 1 s "
              "(m/s^2/sqrt(Hz)).")
        .real("accelerometer_bias_mps2", a.bias, {0, 10},
              "Standard deviation of the bias, drawn for each axis.")
        .real("accelerometer_drift_mps2", a.drift, {0, 10},
              "Standard deviation of how the bias wanders during the drive.")
        .real("accelerometer_drift_s", a.drift_s, {1, 1e6}, "Correlation time of that.")
        .real("accelerometer_scale_error", a.scale_error, {0, 0.1},
              "Standard deviation of the scale factor's error, drawn for each axis.")
        .real("accelerometer_resolution_mps2", a.resolution, {0, 1},
              "Forces are multiples of this; 0: any number.")
        .real("x_m", x_m_, {-100, 100}, "Place on the vehicle, forward of the middle of its axle.")
        .real("y_m", y_m_, {-100, 100}, "To the left.")
        .real("z_m", z_m_, {0, 100}, "Above ground.")
        .angle("yaw_deg", yaw_rad_, {-180, 180}, "Its heading on the vehicle.");
}

Pose3 ImuSensor::T_base_imu() const {
    return {{x_m_, y_m_, z_m_}, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad_, Eigen::Vector3d::UnitZ()))};
}

void ImuSensor::start(const Scene& scene) {
    scene_ = &scene;
    gyro_.emplace(imu_.gyro, imu_.rate_hz, RandomStream(scene.seed, "gyro"));
    accelerometer_.emplace(imu_.accelerometer, imu_.rate_hz, RandomStream(scene.seed, "accelerometer"));
    index_ = 0;
    truth_ = {bias_row("imu_scale", 0, gyro_->scale_error(), accelerometer_->scale_error())};
}

/// Once a second.
void ImuSensor::note_biases(StampNs time_ns) {
    const auto second = static_cast<int>(time_ns / 1'000'000'000);
    if (truth_.back().kind == "imu_bias" && truth_.back().number == second) return;
    truth_.push_back(bias_row("imu_bias", second, gyro_->bias(), accelerometer_->bias()));
}

mrpt::obs::CObservation::Ptr ImuSensor::next() {
    const StampNs time_ns = next_time_ns();
    const auto half_ns = static_cast<StampNs>(std::llround(0.5e9 / imu_.rate_hz));
    const TrueMotion& motion = scene_->drive.motion;
    const InertialRates rates =
        true_rates([&](StampNs at_ns) { return motion.pose_at(at_ns) * T_base_imu(); }, time_ns - half_ns,
                   time_ns + half_ns, motion.step_ns());
    const Eigen::Vector3d omega_radps = gyro_->measured(rates.omega_radps);
    const Eigen::Vector3d force_mps2 = accelerometer_->measured(rates.specific_force_mps2);
    note_biases(time_ns);

    auto observation = mrpt::obs::CObservationIMU::Create();
    observation->sensorLabel = name();
    observation->timestamp = stamp_to_mrpt(scene_->start_ns + time_ns);
    observation->sensorPose = mrpt_pose(T_base_imu());
    observation->set(mrpt::obs::IMU_WX, omega_radps.x());
    observation->set(mrpt::obs::IMU_WY, omega_radps.y());
    observation->set(mrpt::obs::IMU_WZ, omega_radps.z());
    observation->set(mrpt::obs::IMU_X_ACC, force_mps2.x());
    observation->set(mrpt::obs::IMU_Y_ACC, force_mps2.y());
    observation->set(mrpt::obs::IMU_Z_ACC, force_mps2.z());
    ++index_;
    return observation;
}

}  // namespace loopline::simulation
