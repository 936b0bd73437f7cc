/// What module cloud_map and map builder final_cloud_map are asked for, and how they read sweeps and tell
/// what they did.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "api/module.h"
#include "cloud_map/cloud_mapper.h"
#include "lidar/observation_scan.h"

namespace loopline::cloud_map {

struct CloudMapOptions {
    CloudMapSettings settings;
    lidar::SweepConvention cloud_sweep;
    std::vector<std::string> sensors;  ///< labels; empty for all
    double max_gap_s = 0.5;

    /// Bound to this object.
    void declare(ParameterTable& table);
    std::string check() const;
    bool wants(const mrpt::obs::CObservation& observation) const;
};

/// A sweep with the intensity of each of its points, if the log has any.
struct TimedSweep {
    lidar::SpinningScan scan;
    std::vector<std::uint16_t> intensity;

    StampNs begin_ns() const;
    StampNs end_ns() const;
};

struct SweepCounts {
    std::int64_t mapped = 0, without_pose = 0;
};

void tell(const CloudMapper& mapper, const SweepCounts& sweeps, bool removes_moving, Results& results);

}  // namespace loopline::cloud_map
