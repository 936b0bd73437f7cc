/// A planar scan with the place that the final trajectory gives its sensor: what every map builder starts
/// from.
#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <optional>
#include <string>
#include <vector>

#include "api/module.h"
#include "api/planar_scan.h"

namespace mrpt::poses {
class CPose3D;
}

namespace loopline::maps {

/// Keeps its memory from scan to scan.
class ScanInMap {
 public:
    /// Takes `item` if it is a usable 2D scan of one of these sensors (labels; empty: of any) whose sequence
    /// has a finite pose in `trajectory`; false if not, and then the rest is meaningless.
    bool take(const StreamItem& item, const Trajectory& trajectory,
              const std::vector<std::string>& sensors = {});

    const mrpt::obs::CObservation2DRangeScan& observation() const { return *observation_; }
    const TrajectoryEntry& entry() const { return *entry_; }
    /// Beams in the sensor's own plane; its T_base_sensor is a projection, T_map_sensor() is not.
    const PlanarScan& beams() const { return beams_; }
    /// With height, roll and pitch of vehicle and mount.
    const Pose3& T_map_sensor() const { return T_map_sensor_; }

 private:
    const mrpt::obs::CObservation2DRangeScan* observation_ = nullptr;
    std::optional<TrajectoryEntry> entry_;
    PlanarScan beams_;
    Pose3 T_map_sensor_;
};

mrpt::poses::CPose3D to_mrpt(const Pose3& pose);

}  // namespace loopline::maps
