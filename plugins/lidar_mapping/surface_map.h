/// A local map of surfaces: space in cubes of a few sizes, each with the plane or the edge that the returns in
/// it make. (Planes of cubes: Yuan, Xu, Liu, Hong, Zhang 2022, "Efficient and probabilistic adaptive voxel
/// mapping"; planes and edges as the two kinds of features: Zhang and Singh 2014.)
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lidar_mapping/voxel_key.h"

namespace loopline::lidar_mapping {

/// What the returns in a cube lie on.
struct Surface {
    enum class Kind : std::uint8_t { none, plane, edge };
    Kind kind = Kind::none;
    Eigen::Vector3f mean_map_m = Eigen::Vector3f::Zero();
    Eigen::Vector3f direction_map = Eigen::Vector3f::Zero();  ///< normal of a plane, direction of an edge
    float variance_m2 = 0;  ///< of returns about it, and of itself
};

struct SurfaceMapSettings {
    double cell_m = 0.5;        ///< edge of the smallest cubes; each next size is twice as large
    int sizes = 2;
    int enough_returns = 60;    ///< in a cube: more tell nothing new
    int min_returns = 6;
    double max_thickness_m = 0.1;   ///< standard deviation about a plane or an edge
    double min_width_m = 0.08;      ///< standard deviation along it
    double keep_radius_m = 110;
};

/// Coordinates are kept relative to each cube, so that they stay exact far away from the origin.
class SurfaceMap {
 public:
    explicit SurfaceMap(const SurfaceMapSettings& settings);

    void add(const Eigen::Vector3d& p_map_m);
    /// The surface that a return belongs to: of the smallest cube around it that has one.
    /// False if there is none. `p_map_m` minus a point on the surface goes to `offset_m`.
    bool find(const Eigen::Vector3d& p_map_m, Surface::Kind& kind, Eigen::Vector3f& direction,
              Eigen::Vector3f& offset_m, float& variance_m2) const;
    /// Forgets what is farther than `keep_radius_m`.
    void keep_around(const Eigen::Vector3d& p_map_m);

    std::size_t cells() const { return used_; }
    std::size_t bytes() const;

 private:
    struct Cell {
        VoxelKey key = no_voxel;
        // Of returns, from the cube's middle, in parts of its edge.
        std::array<float, 3> sum{};
        std::array<float, 6> squares{};
        std::uint16_t returns = 0, fitted = 0;
        Surface::Kind kind = Surface::Kind::none;
        std::array<float, 3> mean{}, direction{};
        float variance = 0;
    };
    struct Size {
        double edge_m = 0, per_edge = 0;
        std::vector<Cell> table;
        std::size_t used = 0;
    };
    static VoxelIndex index_of(const Size& size, const Eigen::Vector3d& p_map_m);
    Cell& cell_at(Size& size, VoxelKey key);
    static const Cell* find_cell(const Size& size, VoxelKey key);
    void fit(const Size& size, Cell& cell) const;
    void rebuild(Size& size, std::size_t slots, const VoxelIndex* around, int radius);

    SurfaceMapSettings settings_;
    std::vector<Size> sizes_;
    std::size_t used_ = 0;
};

}  // namespace loopline::lidar_mapping
