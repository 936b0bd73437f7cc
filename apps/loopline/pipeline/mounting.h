/// Where sensors sit on the vehicle, if the log is wrong about it.
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <algorithm>

#include "config/experiment.h"

namespace loopline {

class Mounting {
 public:
    explicit Mounting(const MountSettings& settings = {})
        : labels_(settings.sensors),
          T_base_sensor_(settings.x_m, settings.y_m, settings.z_m, settings.yaw_rad, settings.pitch_rad,
                         settings.roll_rad) {}

    void apply(mrpt::obs::CObservation& observation) const {
        if (std::find(labels_.begin(), labels_.end(), observation.sensorLabel) != labels_.end())
            observation.setSensorPose(T_base_sensor_);
    }

 private:
    std::vector<std::string> labels_;
    mrpt::poses::CPose3D T_base_sensor_;
};

}  // namespace loopline
