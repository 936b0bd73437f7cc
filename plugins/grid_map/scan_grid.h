/// A map of cells from which scans can be taken out again (row B1 of the method: "the scan frames between
/// epoch k-n and k are cleared"). All that a scan adds is whole numbers, so that taking it out leaves exactly
/// the map that never had it.
#pragma once

#include <cstdint>
#include <set>
#include <utility>

#include "api/pose2.h"
#include "grid_map/frame.h"
#include "grid_map/sparse_array.h"

namespace loopline::grid_map {

/// What the returns in a cell say together.
struct Surface {
    std::int32_t returns = 0;
    std::int32_t sum_x = 0, sum_y = 0;    ///< of their places within the cell, in 1/1024 of its edge
    std::int32_t sum_nx = 0, sum_ny = 0;  ///< of their normals, in 1/1024
    bool operator==(const Surface& o) const {
        return returns == o.returns && sum_x == o.sum_x && sum_y == o.sum_y && sum_nx == o.sum_nx &&
               sum_ny == o.sum_ny;
    }
};

struct CellIndex {
    int x = 0, y = 0;
};

struct ScanGridSettings {
    double cell_m = 0.05;
    bool free_space = true;  ///< whether to count the beams that pass a cell
};

/// Surfaces, passing beams, and the likelihood of a return for the search, each in its own layer.
class ScanGrid {
 public:
    static constexpr int levels = 6;             ///< of the likelihood: blocks of 1, 2, 4 .. 32 cells
    static constexpr int full_likelihood = 255;  ///< in a cell with a return

    explicit ScanGrid(const ScanGridSettings& settings) : settings_(settings) {}

    void insert(const Frame& frame, const Pose2& T_map_base) { apply(frame, T_map_base, +1); }
    /// A frame that was inserted, at the very pose that it was inserted at. Call settle() after the last of a
    /// few.
    void remove(const Frame& frame, const Pose2& T_map_base) { apply(frame, T_map_base, -1); }
    /// Brings the likelihood up to date where returns were removed.
    void settle();

    double cell_m() const { return settings_.cell_m; }
    CellIndex cell_of(double x_m, double y_m) const {
        return {floor_to_int(x_m / settings_.cell_m), floor_to_int(y_m / settings_.cell_m)};
    }
    const SparseArray<Surface>& surfaces() const { return surfaces_; }
    const SparseArray<std::int32_t>& passes() const { return passes_; }

    /// Level 0: how well a return in this cell fits the map, 255 if there is one, less nearby. Level h: the
    /// best of level 0 over the cells x 2^h .. (x + 2) 2^h - 1, and y alike: a bound for 2^h x 2^h
    /// neighbouring places at once.
    int likelihood(int level, int x, int y) const { return likelihood_[level].value(x, y); }
    const SparseArray<std::uint8_t>& likelihood_layer(int level) const { return likelihood_[level]; }

    std::size_t bytes() const;
    bool operator==(const ScanGrid& other) const;
    /// After removals: gives back memory of cells that hold nothing.
    void drop_empty_tiles();

    static int floor_to_int(double v) {
        const int i = static_cast<int>(v);
        return i > v ? i - 1 : i;
    }

 private:
    void apply(const Frame& frame, const Pose2& T_map_base, int sign);
    void add_pass(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, int sign);
    void raise_likelihood(CellIndex cell);
    void mark_for_settling(CellIndex emptied);
    void raise_bounds(int x, int y, std::uint8_t value);
    void settle_tile(int tile_x, int tile_y);
    void settle_bounds(int h, int tile_x, int tile_y);

    ScanGridSettings settings_;
    SparseArray<Surface> surfaces_;
    SparseArray<std::int32_t> passes_;
    SparseArray<std::uint8_t> likelihood_[levels];
    std::set<std::pair<int, int>> unsettled_;  ///< tiles of level 0 with a return less nearby
};

}  // namespace loopline::grid_map
