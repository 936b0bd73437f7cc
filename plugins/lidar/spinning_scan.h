/// One sweep of a spinning lidar, as odometry and mapping want it: plain points, whatever class the log keeps
/// it in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "api/pose3.h"
#include "api/stamp.h"

namespace loopline::lidar {

/// Where a beam met something, in the frame that the lidar had at that moment: motion is not taken out.
struct SpinningPoint {
    float x_m = 0, y_m = 0, z_m = 0;
    float time_s = 0;  ///< after the scan's stamp; negative: before it
};

struct SpinningScan {
    std::string label;                      ///< sensorLabel
    StampNs stamp_ns = 0;                   ///< UTC
    Pose3 T_base_lidar;                     ///< mounting
    double begin_s = 0;                     ///< of the sweep, after the stamp
    double end_s = 0;                       ///< of the sweep, after the stamp
    std::vector<SpinningPoint> points;      ///< ring after ring, each in the order of its times
    std::vector<std::uint32_t> ring_begin;  ///< first point of each ring, and at last points.size()

    /// From the beam that points highest, 0, to the lowest; one may be empty.
    std::size_t rings() const { return ring_begin.empty() ? 0 : ring_begin.size() - 1; }
    void clear() {
        points.clear();
        ring_begin.clear();
    }
};

}  // namespace loopline::lidar
