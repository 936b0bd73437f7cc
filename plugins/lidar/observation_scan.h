/// Scans of a spinning lidar out of a log's observations.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <memory>
#include <string>
#include <vector>

#include "lidar/cloud_rings.h"
#include "lidar/range_image.h"
#include "lidar/spinning_scan.h"
#include "lidar/velodyne_packets.h"

namespace mrpt::obs {
class CObservationPointCloud;
class CObservationRotatingScan;
class CObservationVelodyneScan;
}  // namespace mrpt::obs

namespace loopline::lidar {

/// A range image as MRPT's class for it; `ranges` row by row, 0 where nothing came back. The stamp is the
/// first column's.
std::shared_ptr<mrpt::obs::CObservationRotatingScan> rotating_scan(const RangeImageGeometry& geometry,
                                                                   const std::string& model,
                                                                   const std::vector<std::uint16_t>& ranges);

/// Keeps tables and memory from scan to scan; one for each sensor.
///
/// CObservationRotatingScan: rings by the elevations in its `lidarModel` (beam_table.h), times by column.
/// CObservationVelodyneScan: rings by the calibration in it, each return at its own time
/// (velodyne_packets.h). CObservationPointCloud: rings by the order of its points, or by their elevations;
/// times by azimuth, as `cloud_sweep` says.
class SpinningScanReader {
 public:
    explicit SpinningScanReader(const SweepConvention& cloud_sweep = {}) : cloud_sweep_(cloud_sweep) {}

    /// False, and nothing in `scan`, if that is no scan of such a lidar: another class, a stamp that is
    /// missing, a model whose elevations nobody knows, numbers that are none, or not a single return.
    ///
    /// `intensity`, if wanted: of each point of the scan, 65535 being full scale; empty if the observation
    /// has none.
    bool read(const mrpt::obs::CObservation& observation, SpinningScan& scan,
              std::vector<std::uint16_t>* intensity = nullptr);

 private:
    using Intensity = std::vector<std::uint16_t>;
    bool read_image(const mrpt::obs::CObservationRotatingScan& image, SpinningScan& scan,
                    Intensity* intensity);
    bool read_points(const mrpt::obs::CObservationPointCloud& cloud, SpinningScan& scan,
                     Intensity* intensity);

    SweepConvention cloud_sweep_;
    RangeImageReader images_;
    RangeImageGeometry geometry_;
    std::string model_;  ///< whose elevations are in `geometry_`
    CloudReader clouds_;
    VelodynePackets packets_;
    std::vector<Eigen::Vector3f> points_m_;
};

}  // namespace loopline::lidar
