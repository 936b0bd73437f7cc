/// Importer "carmen": CARMEN's text logs as rawlogs, with their own stamps and in the file's order.
#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/importer.h"
#include "importers/carmen_geometry.h"

namespace loopline {

class CarmenImporter : public Importer {
    DEFINE_MRPT_OBJECT(CarmenImporter, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string import(const std::vector<std::string>& inputs, RawlogSink& sink) override;

 private:
    enum class Format { sf, observations };
    enum class Stamp { ipc, logger };

    struct Sensor;  ///< what all scans of a log have in common
    Sensor describe_sensor(const carmen::Log& log, RawlogSink& sink) const;
    double aperture_rad(const carmen::Scan& scan, const Sensor& sensor) const;
    mrpt::obs::CObservation2DRangeScan observation_of(const carmen::Scan& scan, const Sensor& sensor) const;
    StampNs stamp_of(const carmen::Times& times) const {
        return stamp_ == Stamp::ipc ? times.ipc_ns : times.logger_ns;
    }
    void write_frames(const carmen::Log& log, const Sensor& sensor, RawlogSink& sink) const;
    void write_observations(const carmen::Log& log, const Sensor& sensor, RawlogSink& sink) const;
    std::string summary(const carmen::Log& log, const Sensor& sensor) const;

    Format format_ = Format::sf;
    Stamp stamp_ = Stamp::ipc;
    double aperture_rad_ = 0;
    double min_range_m_ = 0.02;
    double max_range_m_ = 0;
    double sigma_range_m_ = 0.01;
    Pose2 T_base_laser_;  ///< as given; the identity: not given
};

}  // namespace loopline
