/// Hu 2012, section 2.1: the survey laser's returns, known in its own frame only, are carried into the world
/// by the poses of the vehicle; with corrected poses, again. Here every beam has a pose of its own, that of
/// its own time.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "api/path_sampler.h"
#include "api/planar_scan.h"

namespace loopline::survey {

/// A scan of the survey laser, with the time of each beam.
struct TimedScan {
    PlanarScan beams;  ///< in the sensor's own plane; its T_base_sensor, a projection, is not used
    bool counter_clockwise = true;  ///< in time: beam 0 is measured first, or last
    StampNs first_beam_ns = 0;      ///< the scan's stamp
    double duration_s = 0;          ///< from the first beam to the last
    Pose3 T_base_sensor;            ///< at the first beam
    std::uint64_t sequence = 0;

    StampNs beam_time_ns(std::size_t beam) const;
};

struct RangeGate {
    double min_m = 0;
    double max_m = 1000;
    bool lets_pass(float range_m) const {
        return static_cast<double>(range_m) >= min_m && static_cast<double>(range_m) <= max_m;
    }
};

struct FusionCounts {
    std::int64_t beams = 0;
    std::int64_t without_return = 0;
    std::int64_t out_of_range = 0;
    std::int64_t without_pose = 0;  ///< the trajectory has none at their time
};

/// The mount's motion while a scan was measured: along the screw from its own pose to that at the next scan,
/// or, for the last one, on from the scan before. Where there is neither within `max_gap_s`, it stands still.
ScrewSegment mount_motion(const TimedScan* previous, const TimedScan& scan, const TimedScan* next,
                          double max_gap_s);

/// Appends to `points_map` the returns of `scan` in the map frame, in the order of their angle:
///     p_map = T_map_base(t) T_base_sensor(t) p_sensor,  t the time of the beam.
void fuse(const TimedScan& scan, const ScrewSegment& T_base_sensor, PathSampler& T_map_base,
          const RangeGate& gate, std::vector<Eigen::Vector3f>& points_map, FusionCounts& counts);

}  // namespace loopline::survey
