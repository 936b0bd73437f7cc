/// Sensors "horizontal_laser" and "survey_laser", which a servo tilts up and down.
#pragma once

#include <optional>

#include "simulation/laser.h"
#include "simulation/sensor.h"
#include "simulation/servo.h"

namespace loopline::simulation {

/// CObservation2DRangeScan. Its stamp and its sensorPose are those of the first beam; beams follow from right
/// to left, evenly within `sweep_part` of the time to the next scan.
class LaserSensor : public Sensor {
 public:
    std::string check() const override;
    bool is_scanner() const override { return true; }
    bool sees_walls_only() const override { return true; }
    void start(const Scene& scene) override;
    StampNs next_time_ns() const override { return sample_time_ns(index_, laser_.rate_hz); }
    mrpt::obs::CObservation::Ptr next() override;
    std::string summary() const override;

 protected:
    /// Sensor frame in the vehicle's, at a time.
    virtual Pose3 T_base_sensor(StampNs time_ns) const = 0;
    ParameterTable declared(const std::string& sentence);

    LaserSettings laser_;
    Pose3 mount() const;
    double x_m_ = 0.2, y_m_ = 0, z_m_ = 0.35, yaw_rad_ = 0;

 private:
    const Scene* scene_ = nullptr;
    std::optional<Laser> model_;
    std::int64_t index_ = 0, returns_ = 0;
};

class HorizontalLaser : public LaserSensor {
 public:
    std::string name() const override { return "horizontal_laser"; }
    ParameterTable parameters() override {
        return declared("A laser that scans a horizontal plane: CObservation2DRangeScan.");
    }

 private:
    Pose3 T_base_sensor(StampNs) const override { return mount(); }
};

/// deltaPitch is what the servo turns within a scan.
class SurveyLaser : public LaserSensor {
 public:
    SurveyLaser();
    std::string name() const override { return "survey_laser"; }
    ParameterTable parameters() override;
    std::string check() const override;
    bool is_scanner() const override { return false; }
    mrpt::obs::CObservation::Ptr next() override;
    std::string summary() const override;

 private:
    Pose3 T_base_sensor(StampNs time_ns) const override;

    ServoSettings servo_;
    double arm_m_ = 0.05;
    StampNs last_ns_ = 0;
};

}  // namespace loopline::simulation
