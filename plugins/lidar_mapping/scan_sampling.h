/// A sweep thinned out evenly in space: what a lidar sees a thousand times close by counts no more than what
/// it sees once far away.
#pragma once

#include <cstdint>
#include <vector>

#include "lidar/spinning_scan.h"
#include "lidar_mapping/voxel_key.h"

namespace loopline::lidar_mapping {

/// A return in the vehicle's frame at the moment of its beam.
struct SweepPoint {
    Eigen::Vector3f p_base_m;
    float time_s = 0;           ///< after the middle of the sweep
    Eigen::Vector3f beam_base;  ///< direction in which it was seen, of length 1
};

struct SamplingSettings {
    double min_range_m = 1.5, max_range_m = 100;  ///< the paper's eq. (7): nothing outside counts
};

/// Keeps its table from scan to scan.
class ScanSampler {
 public:
    /// The points of a scan within the range gate, the first of each cube of `voxel_m` around the lidar.
    void sample(const lidar::SpinningScan& scan, const SamplingSettings& settings, double voxel_m,
                std::vector<SweepPoint>& points);
    /// Those points again, the first of each larger cube.
    void thin_out(const std::vector<SweepPoint>& points, double voxel_m, std::vector<SweepPoint>& fewer);

 private:
    void begin(std::size_t points, double voxel_m);
    VoxelKey voxel_of(const Eigen::Vector3f& p_m) const;
    /// Whether nothing of this cube was seen since begin().
    bool is_first(VoxelKey key);
    /// take(i), in their order, for those of `count` places that are the first in their cubes; place_of(i) is
    /// none for those that do not count.
    template <class PlaceOf, class Take>
    void for_firsts(std::size_t count, PlaceOf place_of, Take take);

    float per_voxel_ = 1;
    std::uint32_t round_ = 0;
    std::size_t mask_ = 0;
    struct Slot {
        VoxelKey key;
        std::uint32_t round;
    };
    std::vector<Slot> slots_;
};

}  // namespace loopline::lidar_mapping
