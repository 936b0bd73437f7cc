/// Where sensors sit on the vehicle and what their scans lack, if the log is wrong about it.
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/poses/CPose3D.h>

#include <algorithm>

#include "config/experiment.h"

namespace loopline {

class Mounting {
 public:
    explicit Mounting(const MountSettings& settings = {})
        : labels_(settings.sensors),
          T_base_sensor_(settings.x_m, settings.y_m, settings.z_m, settings.yaw_rad, settings.pitch_rad,
                         settings.roll_rad),
          range_scale_(settings.range_scale),
          range_offset_m_(settings.range_offset_m),
          aperture_rad_(static_cast<float>(settings.aperture_rad)) {}

    void apply(mrpt::obs::CObservation& observation) const {
        if (std::find(labels_.begin(), labels_.end(), observation.sensorLabel) == labels_.end()) return;
        observation.setSensorPose(T_base_sensor_);
        auto* scan = dynamic_cast<mrpt::obs::CObservation2DRangeScan*>(&observation);
        if (scan == nullptr) return;
        if (aperture_rad_ > 0) scan->aperture = aperture_rad_;
        if (range_scale_ == 1 && range_offset_m_ == 0) return;
        scan->maxRange = corrected(scan->maxRange);
        for (std::size_t i = 0; i < scan->getScanSize(); ++i)
            if (scan->getScanRange(i) > 0) scan->setScanRange(i, corrected(scan->getScanRange(i)));
    }

 private:
    float corrected(float range_m) const {
        return static_cast<float>(range_scale_ * static_cast<double>(range_m) + range_offset_m_);
    }

    std::vector<std::string> labels_;
    mrpt::poses::CPose3D T_base_sensor_;
    double range_scale_, range_offset_m_;
    float aperture_rad_;
};

}  // namespace loopline
