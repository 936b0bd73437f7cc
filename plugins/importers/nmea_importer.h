/// Importer "nmea": what a GNSS receiver says in NMEA 0183, line after line, as CObservationGPS.
#pragma once

#include "api/importer.h"
#include "gnss/nmea_log.h"

namespace loopline {

class NmeaImporter : public Importer {
    DEFINE_MRPT_OBJECT(NmeaImporter, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    std::string check() const override;
    std::string import(const std::vector<std::string>& inputs, RawlogSink& sink) override;

 private:
    std::string label_ = "gnss";
    std::string date_;  ///< "2024-05-31"; empty: the log's own
    Eigen::Vector3d p_base_antenna_m_ = Eigen::Vector3d::Zero();
};

}  // namespace loopline
