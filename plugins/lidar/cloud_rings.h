/// Rings and times of a cloud that a spinning lidar made and somebody saved as bare points, such as KITTI's
/// .bin files.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar/spinning_scan.h"

namespace loopline::lidar {

/// How the lidar turned. The defaults are those of KITTI's: clockwise from behind, so that it looks forward
/// in the middle of the sweep, which is the stamp.
struct SweepConvention {
    double sweep_s = 0.1;
    double first_azimuth_rad = 3.14159265358979323846;  ///< counter-clockwise from the x axis
    bool clockwise = true;
    double stamp_part = 0.5;  ///< of the sweep that is over at the stamp
};

/// When a beam at this azimuth was measured, after the stamp.
double time_of_azimuth_s(const SweepConvention& convention, double azimuth_rad);

/// Where a point lies, seen from the lidar.
struct BeamDirection {
    float azimuth_rad;  ///< -pi .. pi, counter-clockwise from the x axis
    float slope;        ///< tangent of the elevation, which orders beams as the angle does
};
/// No point may lie on the lidar's own axis.
std::vector<BeamDirection> directions_of(const std::vector<Eigen::Vector3f>& points_m);

/// Which ring each point belongs to.
struct RingsOfCloud {
    std::vector<std::uint16_t> ring_of_point;
    std::size_t rings = 0;  ///< 0: none could be told
};

/// Where points are stored ring after ring, as KITTI's are: a ring ends where the azimuth begins anew. No
/// ring if the cloud is not stored like that: if elevations within a ring differ as they do from ring to
/// ring.
RingsOfCloud rings_by_order(const std::vector<BeamDirection>& directions);

/// Any order: elevations form clusters with gaps between them; where there are no gaps, `bands` of equal
/// height.
RingsOfCloud rings_by_elevation(const std::vector<BeamDirection>& directions, std::size_t bands = 64);

/// Rings by order, else by elevation. No point may lie on the lidar's own axis.
void read_cloud(const std::vector<Eigen::Vector3f>& points_m, const SweepConvention& convention,
                SpinningScan& scan);

}  // namespace loopline::lidar
