/// Lines as an observation: recorded in a rawlog, read back, and fed to any module in place of the scan.
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <memory>
#include <string>

#include "lines/line_segment.h"

namespace mrpt::obs {
class CObservation2DRangeScan;
}

namespace loopline {

/// What extracts the lines of a scan when they are asked for.
class LineSource {
 public:
    virtual ~LineSource() = default;
    virtual void extract(const mrpt::obs::CObservation2DRangeScan& scan, lines::LineSegments& segments) = 0;
};

/// The straight walls of one scan, in the frame of the sensor that took it, with the scan's time.
class CObservationLines : public mrpt::obs::CObservation {
    DEFINE_SERIALIZABLE(CObservationLines, loopline)
 public:
    /// In the order of their first beam. Extracted from the scan when somebody looks for the first time: a
    /// consumer that takes every twentieth scan only does not pay for the others.
    const lines::LineSegments& segments() const;
    void set_segments(lines::LineSegments segments);
    /// `source` is asked at most once, and must live until then.
    void set_source(LineSource& source, std::shared_ptr<const mrpt::obs::CObservation2DRangeScan> scan);

    mrpt::poses::CPose3D sensor_pose;  ///< T_base_sensor of the scan
    std::string scan_label;            ///< sensorLabel of the scan
    std::size_t scan_beams = 0;        ///< beams of the scan, with or without a return

    void getSensorPose(mrpt::poses::CPose3D& out_pose) const override { out_pose = sensor_pose; }
    void setSensorPose(const mrpt::poses::CPose3D& pose) override { sensor_pose = pose; }
    void getDescriptionAsText(std::ostream& o) const override;

 private:
    mutable lines::LineSegments segments_;
    mutable LineSource* source_ = nullptr;
    mutable std::shared_ptr<const mrpt::obs::CObservation2DRangeScan> scan_;
};

}  // namespace loopline
