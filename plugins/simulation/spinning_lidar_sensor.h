/// Sensor "spinning_lidar".
#pragma once

#include <optional>

#include "simulation/sensor.h"
#include "simulation/spinning_lidar.h"

namespace loopline::simulation {

/// CObservationRotatingScan, which the class's own text defines by its first column: the stamp is when that
/// was fired. Where a scenario has a plan of walls instead of a landscape, those are what it sees.
class SpinningLidarSensor : public Sensor {
 public:
    std::string name() const override { return "spinning_lidar"; }
    ParameterTable parameters() override;
    std::string check() const override;
    bool is_scanner() const override { return true; }
    bool is_slow() const override { return true; }
    void start(const Scene& scene) override;
    StampNs next_time_ns() const override { return sample_time_ns(index_, settings_.rate_hz); }
    mrpt::obs::CObservation::Ptr next() override;
    std::string summary() const override;

    const SpinningLidarSettings& settings() const { return settings_; }

 private:
    Pose3 mount() const;

    SpinningLidarSettings settings_;
    double x_m_ = 0, y_m_ = 0, z_m_ = 1.73, yaw_rad_ = 0, pitch_rad_ = 0;
    const Scene* scene_ = nullptr;
    TriangleMesh walls_;  ///< of a scene without landscape
    std::unique_ptr<MeshCaster> caster_;
    std::optional<SpinningLidar> model_;
    std::int64_t index_ = 0, returns_ = 0;
};

}  // namespace loopline::simulation
