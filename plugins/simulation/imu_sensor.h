/// Sensor "imu": a MEMS inertial measurement unit.
#pragma once

#include <optional>

#include "simulation/imu.h"
#include "simulation/sensor.h"

namespace loopline::simulation {

/// CObservationIMU: angular rates (rad/s) and specific forces (m/s^2) in the axes of the sensor, means over
/// one sample interval with the stamp in its middle.
class ImuSensor : public Sensor {
 public:
    std::string name() const override { return "imu"; }
    ParameterTable parameters() override;
    void start(const Scene& scene) override;
    StampNs next_time_ns() const override { return sample_time_ns(index_, imu_.rate_hz); }
    mrpt::obs::CObservation::Ptr next() override;
    std::vector<TruthRow> truth() const override { return truth_; }

 private:
    Pose3 T_base_imu() const;
    void note_biases(StampNs time_ns);

    ImuSettings imu_;
    double x_m_ = 0, y_m_ = 0, z_m_ = 0.2, yaw_rad_ = 0;
    const Scene* scene_ = nullptr;
    std::optional<Triad> gyro_, accelerometer_;
    std::int64_t index_ = 0;
    std::vector<TruthRow> truth_;
};

}  // namespace loopline::simulation
