/// Which cubes of space are taken: thins a point cloud to one point a cube.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <unordered_set>

namespace loopline::maps {

/// A hashed grid of cubes; only membership is ever asked, so the result does not depend on the order of the
/// hash.
class VoxelSet {
 public:
    explicit VoxelSet(double edge_m) : per_m_(1 / edge_m) {}

    /// True if the point's cube was free; it is taken then. False too for a point more than 2^20 cubes from
    /// the origin, or not finite.
    bool take(const Eigen::Vector3d& point_m) {
        constexpr double limit = 1 << 20;  // 21 bits a coordinate
        std::uint64_t key = 0;
        for (int i = 0; i < 3; ++i) {
            const double cube = std::floor(point_m[i] * per_m_);
            if (!(std::abs(cube) < limit)) return false;
            key = key << 21 | static_cast<std::uint64_t>(static_cast<std::int64_t>(cube + limit));
        }
        return taken_.insert(key).second;
    }

 private:
    /// Neighbouring keys differ in few bits: mix them (Steele et al. 2014, SplitMix64's finaliser).
    struct Mix {
        std::size_t operator()(std::uint64_t key) const {
            key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9;
            key = (key ^ (key >> 27)) * 0x94d049bb133111eb;
            return key ^ (key >> 31);
        }
    };
    double per_m_;
    std::unordered_set<std::uint64_t, Mix> taken_;
};

}  // namespace loopline::maps
