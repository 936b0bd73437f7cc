/// Sensors "wheels", the encoders with dead reckoning, and "commands", the way to drive that was asked for.
#pragma once

#include "simulation/encoders.h"
#include "simulation/sensor.h"

namespace loopline::simulation {

/// CObservationOdometry: cumulative pose, encoder ticks, mean velocity since the reading before.
class WheelSensor : public Sensor {
 public:
    std::string name() const override { return "wheels"; }
    ParameterTable parameters() override;
    void start(const Scene& scene) override;
    StampNs next_time_ns() const override { return sample_time_ns(index_, rate_hz_); }
    mrpt::obs::CObservation::Ptr next() override;

 private:
    double rate_hz_ = 20;
    double track_scale_ = 1;
    double sigma_scale_ = 0;
    double sigma_common_scale_ = 0;
    EncoderSettings settings_;
    const Scene* scene_ = nullptr;
    std::unique_ptr<Encoders> encoders_;
    std::int64_t index_ = 0;
};

/// CObservationComment at each change of the commanded regime: "straight", "left" or "right".
class CommandSensor : public Sensor {
 public:
    std::string name() const override { return "commands"; }
    ParameterTable parameters() override;
    void start(const Scene& scene) override;
    StampNs next_time_ns() const override;
    mrpt::obs::CObservation::Ptr next() override;
    std::string summary() const override;

 private:
    const Scene* scene_ = nullptr;
    std::size_t index_ = 0;
};

}  // namespace loopline::simulation
