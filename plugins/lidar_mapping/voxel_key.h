/// Cubes of space by whole numbers, packed into one number to be hashed.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace loopline::lidar_mapping {

/// Three numbers of 21 bits: with cubes of 0.1 m, 100 km to each side of the origin.
using VoxelKey = std::uint64_t;
constexpr VoxelKey no_voxel = ~VoxelKey{0};

struct VoxelIndex {
    std::int32_t x = 0, y = 0, z = 0;
};

inline std::int32_t floor_to_int(float v) {
    const auto i = static_cast<std::int32_t>(v);
    return static_cast<float>(i) > v ? i - 1 : i;
}

inline VoxelKey pack(const VoxelIndex& v) {
    constexpr VoxelKey mask = (VoxelKey{1} << 21) - 1;
    return (static_cast<VoxelKey>(v.x) & mask) << 42 | (static_cast<VoxelKey>(v.y) & mask) << 21 |
           (static_cast<VoxelKey>(v.z) & mask);
}

/// Spreads neighbouring keys over a table (the finaliser of splitmix64).
inline std::size_t hash(VoxelKey key) {
    key = (key ^ key >> 30) * 0xbf58476d1ce4e5b9U;
    key = (key ^ key >> 27) * 0x94d049bb133111ebU;
    return static_cast<std::size_t>(key ^ key >> 31);
}

}  // namespace loopline::lidar_mapping
