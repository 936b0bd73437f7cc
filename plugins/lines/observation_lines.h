/// Lines as an observation: recorded in a rawlog, read back, and fed to any module in place of the scan.
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <functional>
#include <string>

#include "lines/line_segment.h"

namespace loopline {

/// The straight walls of one scan, in the frame of the sensor that took it, with the scan's time.
class CObservationLines : public mrpt::obs::CObservation {
    DEFINE_SERIALIZABLE(CObservationLines, loopline)
 public:
    using Extraction = std::function<void(lines::LineSegments&)>;

    /// In the order of their first beam. Extracted from the scan when somebody looks for the first time: a
    /// consumer that takes every twentieth scan only does not pay for the others.
    const lines::LineSegments& segments() const;
    void set_segments(lines::LineSegments segments);
    /// `extraction` is called at most once, and must not outlive what it refers to.
    void set_extraction(Extraction extraction);

    mrpt::poses::CPose3D sensor_pose;  ///< T_base_sensor of the scan
    std::string scan_label;            ///< sensorLabel of the scan
    std::size_t scan_beams = 0;        ///< beams of the scan, with or without a return

    void getSensorPose(mrpt::poses::CPose3D& out_pose) const override { out_pose = sensor_pose; }
    void setSensorPose(const mrpt::poses::CPose3D& pose) override { sensor_pose = pose; }
    void getDescriptionAsText(std::ostream& o) const override;

 private:
    mutable lines::LineSegments segments_;
    mutable Extraction extraction_;
};

}  // namespace loopline
