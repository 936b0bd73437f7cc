/// A local map of surfaces: space in cubes of a few sizes, each with the plane or the edge that the returns
/// in it make. (Planes of cubes: Yuan, Xu, Liu, Hong, Zhang 2022, "Efficient and probabilistic adaptive voxel
/// mapping"; planes and edges as the two kinds of features: Zhang and Singh 2014.)
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "lidar_mapping/voxel_key.h"

namespace loopline::lidar_mapping {

enum class SurfaceKind : std::uint8_t { none, plane, edge };

/// What the returns around a place lie on.
struct SurfaceMatch {
    SurfaceKind kind = SurfaceKind::none;
    Eigen::Vector3f direction_map;  ///< normal of a plane, direction of an edge
    Eigen::Vector3f offset_m;       ///< the place minus a point of the surface
    /// Of a return about the surface there: its scatter, and what the surface itself is uncertain by, more
    /// the farther off it is from the returns that it was made of.
    float variance_m2 = 0;
    /// Of a plane: two directions in it, and the variances of the normal's error towards each.
    Eigen::Vector3f along_map, beside_map;
    float turn_along = 0, turn_beside = 0;
    float sweep = 0;  ///< mean number of the sweeps that it was made of, as the map counts them
};

/// Where a beam met something. Noise of its range moves it along the beam.
struct MapReturn {
    Eigen::Vector3d p_map_m;
    Eigen::Vector3f beam_map;  ///< of length 1
};

/// Where a return lies that is added. `noise_m2`: covariance of the place, by the range's noise and by what
/// is not known of the pose.
struct PlacedReturn {
    Eigen::Vector3d p_map_m;
    Eigen::Matrix3f noise_m2;
};

struct SurfaceMapSettings {
    double cell_m = 0.5;  ///< edge of the smallest cubes; each next size is twice as large
    int sizes = 4;
    int min_returns = 6;                 ///< in different parts of a cube
    double sigma_range_m = 0.02;         ///< no surface is known to be flatter than this
    double max_thickness_m = 0.1;        ///< standard deviation about a plane or an edge
    double max_sigma_normal_rad = 0.05;  ///< a plane whose direction is less certain says nothing
    double max_sigma_m = 0.1;            ///< a surface less certain than this at a place is none there
    double keep_radius_m = 110;
};

/// Coordinates are kept relative to each cube, so that they stay exact far away from the origin.
class SurfaceMap {
 public:
    explicit SurfaceMap(const SurfaceMapSettings& settings);

    /// What is added from here on is of another sweep.
    void begin_sweep() { ++sweeps_; }
    std::uint32_t sweeps() const { return sweeps_; }
    /// Adds to the cubes of one size; sizes have nothing to do with one another.
    void add(std::size_t size, const PlacedReturn& seen);
    void add(std::size_t size, const std::vector<PlacedReturn>& returns);
    std::size_t sizes() const { return sizes_.size(); }
    /// The most certain surface among those of the cubes around a place, from size `smallest` on; kind `none`
    /// if there is none.
    SurfaceMatch find(const MapReturn& seen, std::size_t smallest = 0) const;
    /// The same for so many places at once, which waits less for memory. Arrays of `count` each.
    static constexpr std::size_t at_once = 16;
    void find(const MapReturn* seen, std::size_t count, std::size_t smallest, SurfaceMatch* best) const;
    /// Whether there was a return within a part of the smallest cubes, a quarter of their edge, of a place.
    bool has_return_near(const Eigen::Vector3d& p_map_m) const;
    /// Planes of the second smallest cubes, away from their faces: normal, and the variance of its worse
    /// known direction.
    void for_each_plane(const std::function<void(const Eigen::Vector3f&, float)>& see) const;
    /// Forgets what is farther than `keep_radius_m`.
    void keep_around(const Eigen::Vector3d& p_map_m);

    void clear();
    std::size_t cells() const;

 private:
    template <class Archive>
    friend void fields(Archive&, SurfaceMap&);
    struct Cell {
        VoxelKey key = no_voxel;
        std::uint64_t seen = 0;  ///< which of its 4 x 4 x 4 parts have given a return; one of each counts
        // Of returns, from the cube's middle, in parts of its edge; squares without those of noise.
        std::array<float, 3> sum{};
        std::array<float, 6> squares{};
        float noise = 0;   ///< sum of what was taken off
        float sweeps = 0;  ///< sum of the numbers of their sweeps
        // Of the surface: normal of a plane, or direction of an edge.
        std::array<float, 3> direction{}, along{};  ///< `along`: the plane's direction that is known best
        float variance_m2 = 0;                      ///< across, without noise of ranges
        float per_along_m2 = 0, per_beside_m2 = 0;  ///< inverse variances of the returns in the plane
        std::uint8_t returns = 0, fitted = 0;
        SurfaceKind kind = SurfaceKind::none;
    };
    /// Cubes lie one behind the other in pieces that never move; a table of slots tells where.
    struct Size {
        double edge_m = 0, per_edge = 0;
        struct Slot {
            VoxelKey key = no_voxel;
            std::uint32_t cell = 0;
        };
        std::vector<Slot> slots;
        std::vector<std::unique_ptr<Cell[]>> pieces;
        std::uint32_t cells = 0;

        static constexpr std::uint32_t piece_cells = 4096;
        Cell& operator[](std::uint32_t k) { return pieces[k / piece_cells][k % piece_cells]; }
        const Cell& operator[](std::uint32_t k) const { return pieces[k / piece_cells][k % piece_cells]; }
    };
    struct Asked {
        VoxelIndex index;
        VoxelKey key = no_voxel;
        const Cell* cell = nullptr;  ///< none: there is no such cube
    };
    template <class PlaceOf>
    static void ask(const Size& size, std::size_t count, PlaceOf place_of, std::array<Asked, at_once>& asked);
    static VoxelIndex index_of(const Size& size, const Eigen::Vector3d& p_map_m);
    static Cell& cell_at(Size& size, VoxelKey key);
    static const Cell* find_cell(const Size& size, VoxelKey key);
    static Cell& append(Size& size, VoxelKey key);
    static void make_slots(Size& size, std::size_t slots);
    void add(Size& size, const VoxelIndex& index, VoxelKey key, const PlacedReturn& seen);
    void fit(const Size& size, Cell& cell) const;
    void look(const Size& size, const VoxelIndex& index, const Cell& cell, const MapReturn& seen,
              SurfaceMatch& best) const;

    SurfaceMapSettings settings_;
    std::vector<Size> sizes_;
    std::uint32_t sweeps_ = 0;
};

}  // namespace loopline::lidar_mapping
