/// A lidar that spins: columns of beams, each fired at its own time from its own pose, with noise, beams that
/// are lost, and other vehicles in motion.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "api/pose3.h"
#include "api/stamp.h"
#include "lidar/range_image.h"
#include "simulation/mesh/mesh_caster.h"
#include "simulation/random_stream.h"
#include "simulation/town/traffic.h"

namespace loopline::simulation {

struct SpinningLidarSettings {
    int beams = 64;       ///< of a column: 16, 32 or 64, which have the elevations of their models
    int columns = 1800;   ///< of a turn
    double rate_hz = 10;  ///< turns a second
    double min_range_m = 1;
    double max_range_m = 120;
    double sigma_range_m = 0.02;
    double dropouts = 0.01;           ///< part of the beams that are lost wherever they point
    double least_reflectance = 0.02;  ///< that comes back from `max_range_m` half of the times, met square
};

/// Clockwise from behind, as KITTI's turns: ahead in the middle of the sweep. Ranges in units of 2 mm.
lidar::RangeImageGeometry geometry_of(const SpinningLidarSettings& settings);

/// What moves, at the time of a column.
using BodiesAt = std::function<std::vector<MovingBody>(StampNs time_ns)>;

/// Everything that can be seen, besides what stands still.
struct MovingWorld {
    const std::vector<TriangleMesh>* meshes = nullptr;  ///< of the bodies
    BodiesAt at;                                        ///< empty: nothing moves
};

class SpinningLidar {
 public:
    SpinningLidar(const SpinningLidarSettings& settings, RandomStream random);

    /// Row by row from the highest beam, 0 where nothing came back. Column 0 is fired at `start_ns`, when the
    /// stamp is; `T_map_lidar` gives the pose at a time.
    const std::vector<std::uint16_t>& scan(StampNs start_ns, const std::function<Pose3(StampNs)>& T_map_lidar,
                                           const MeshCaster& world, const MovingWorld& moving = {});
    const lidar::RangeImageGeometry& geometry() const { return geometry_; }

 private:
    void aim(const Pose3& T_map_lidar, int column);
    void look_at_bodies(StampNs time_ns, const MovingWorld& moving);
    void meet(const TriangleMesh& mesh, const Pose3& T_map_body);
    std::uint16_t measured(const MeshHit& hit);

    SpinningLidarSettings settings_;
    RandomStream random_;
    lidar::RangeImageGeometry geometry_;
    std::vector<Eigen::Vector3d> beams_;  ///< directions within the plane y = 0
    std::vector<MeshRay> rays_;           ///< of the column at work
    std::vector<MeshHit> hits_;
    std::vector<std::uint16_t> ranges_;
};

}  // namespace loopline::simulation
