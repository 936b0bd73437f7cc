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

/// Where a point lies, seen from the lidar.
struct BeamDirection {
    float azimuth_rad;  ///< -pi .. pi, counter-clockwise from the x axis
    float slope;        ///< tangent of the elevation, which orders beams as the angle does
};
/// No point may lie on the lidar's own axis. Azimuths are right to 1e-5, which is a fraction of a microsecond
/// of a sweep.
void find_directions(const std::vector<Eigen::Vector3f>& points_m, std::vector<BeamDirection>& directions);

/// Which ring each point belongs to.
struct RingsOfCloud {
    std::vector<std::uint16_t> ring_of_point;
    std::size_t rings = 0;             ///< 0: none could be told
    std::vector<std::uint32_t> count;  ///< points of each ring
    std::vector<double> slope;         ///< mean of each ring
};

/// Where points are stored ring after ring, as KITTI's are: a ring ends where the azimuth begins anew. No
/// ring if the cloud is not stored like that: if elevations within a ring differ as they do from ring to
/// ring.
void find_rings_by_order(const std::vector<BeamDirection>& directions, RingsOfCloud& found);

/// Any order: elevations form clusters with gaps between them; where there are no gaps, `bands` of equal
/// height.
void find_rings_by_elevation(const std::vector<BeamDirection>& directions, RingsOfCloud& found,
                             std::size_t bands = 64);

/// Keeps its memory from cloud to cloud.
class CloudReader {
 public:
    /// Rings by order, else by elevation. No point may lie on the lidar's own axis. `sources`, if wanted: the
    /// place in `points_m` of each point of the scan.
    void read(const std::vector<Eigen::Vector3f>& points_m, const SweepConvention& convention,
              SpinningScan& scan, std::vector<std::uint32_t>* sources = nullptr);

 private:
    void sort_into(const std::vector<Eigen::Vector3f>& points_m, const SweepConvention& convention,
                   SpinningScan& scan);
    void trace(const SpinningScan& scan, const std::vector<Eigen::Vector3f>& points_m,
               const SweepConvention& convention, std::vector<std::uint32_t>& sources);

    std::vector<BeamDirection> directions_;
    RingsOfCloud found_;
    std::vector<std::uint32_t> next_;  ///< place of each ring's next point
};

}  // namespace loopline::lidar
