/// A finished point cloud as a map to be localised in: the surfaces that sweeps are matched with, and what
/// stands upright, to search for a start. Nothing is added later, and nothing forgotten.
#pragma once

#include <Eigen/Core>

#include "api/worker_pool.h"
#include "cloud_localisation/upright_columns.h"
#include "lidar_mapping/surface_map.h"
#include "point_files/point_file.h"

namespace loopline::cloud_localisation {

class FrozenCloud {
 public:
    /// Reads the file once, in pieces: memory holds the map, not the cloud. Throws PointFileError.
    FrozenCloud(const PointFile& file, const lidar_mapping::SurfaceMapSettings& settings,
                WorkerPool& workers);

    const lidar_mapping::SurfaceMap& surfaces() const { return surfaces_; }
    const UprightColumns& columns() const { return columns_; }
    std::size_t points() const { return points_; }
    /// The area that has points.
    double area_m2() const {
        return static_cast<double>(columns_.size()) * UprightColumns::cell_m * UprightColumns::cell_m;
    }
    /// How far a place is from the box about all points, seen from above; 0 within it.
    double distance_m(const Eigen::Vector3d& p_map_m) const;

 private:
    void add(const std::vector<Eigen::Vector3d>& points_m, WorkerPool& workers);

    lidar_mapping::SurfaceMap surfaces_;
    UprightColumns columns_;
    std::size_t points_ = 0;
    Eigen::Vector2d low_m_, high_m_;
};

}  // namespace loopline::cloud_localisation
