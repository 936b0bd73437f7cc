/// What stands upright, seen from above: space in columns, each with its lowest and highest point. Walls,
/// trunks and poles are found by it in a map and in a sweep alike, whatever the ground does.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "lidar_mapping/voxel_key.h"

namespace loopline::cloud_localisation {

class UprightColumns {
 public:
    static constexpr double cell_m = 0.5;
    static constexpr float upright_m = 1;  ///< from the lowest to the highest point at least
    struct Column {
        lidar_mapping::VoxelKey key = lidar_mapping::no_voxel;
        float low_m = 0, high_m = 0;
        bool is_upright() const { return high_m - low_m >= upright_m; }
    };

    UprightColumns() : slots_(first_slots) {}
    void add(const Eigen::Vector3d& p_m);
    /// Null where there is no point.
    const Column* find(int x, int y) const;
    const Column* find(double x_m, double y_m) const { return find(index_of(x_m), index_of(y_m)); }
    std::size_t size() const { return count_; }
    void clear();

    static int index_of(double v_m) { return static_cast<int>(std::floor(v_m / cell_m)); }

 private:
    static constexpr std::size_t first_slots = 1024;
    void grow();
    std::size_t slot_of(lidar_mapping::VoxelKey key) const;

    std::vector<Column> slots_;
    std::size_t count_ = 0;
};

}  // namespace loopline::cloud_localisation
