/// The module `lines`: scans in, line observations out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "api/module.h"
#include "api/observation_pool.h"
#include "lines/extraction_parameters.h"
#include "lines/line_extractor.h"
#include "lines/observation_lines.h"

namespace loopline {

class LineExtraction : public Module, private LineSource {
    DEFINE_MRPT_OBJECT(LineExtraction, loopline)
 public:
    ModuleInfo info() const override;
    ParameterTable parameters() override;
    void start(const RunContext&) override;
    /// Publishes a CObservationLines with the stamp of the scan, also when the scan holds no line. The lines
    /// are extracted when a module or the recorder looks at them, which must be while this module lives.
    void process(const StreamItem& item, Publisher& publisher) override;
    void finish(Results& results) override;
    bool can_resume() const override { return true; }
    void save_state(mrpt::serialization::CArchive& out) const override;
    void load_state(mrpt::serialization::CArchive& in) override;

 private:
    bool wanted(const std::string& sensor_label) const;
    void label(CObservationLines& lines, const std::string& scan_label) const;
    void extract(const mrpt::obs::CObservation2DRangeScan& scan, lines::LineSegments& segments) override;

    lines::ExtractionParameters extraction_;
    std::vector<std::string> sensors_;  ///< labels; empty: all
    std::string label_ = "lines";

    std::unique_ptr<lines::LineExtractor> extractor_;
    PlanarScan scan_;
    ObservationPool<CObservationLines> pool_;
    std::int64_t scans_ = 0, unusable_scans_ = 0;
};

}  // namespace loopline
