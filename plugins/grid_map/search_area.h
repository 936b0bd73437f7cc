/// The likelihood of a map where a search will ask for it, dense, with its best over blocks of cells: bounds
/// for many places of a search at once.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "grid_map/scan_grid.h"

namespace loopline::grid_map {

class SearchArea {
 public:
    static constexpr int block =
        16;  ///< places to a side that share one bound, and places in a row that are tried together
    static constexpr int rows = 4;  ///< rows of a block that share one bound for each place in a row

    /// Places (x + dx, y + dy) with dx and dy up to these to both sides of each cell. None if the cells lie
    /// too far apart for a dense map. There is one area a thread, whose memory is used again.
    static SearchArea* around(const ScanGrid& grid, const std::vector<std::vector<CellIndex>>& cells,
                              int cells_x, int cells_y);

    /// Whether the places of a heading are more than one block: only then are there bounds of blocks.
    bool has_blocks() const { return has_blocks_; }

    /// Where a cell is in the layers below; a place beside it is at + dx + dy * stride().
    std::int32_t at(CellIndex cell) const { return (cell.y - y0_) * stride_ + (cell.x - x0_); }
    std::int32_t stride() const { return stride_; }
    /// Level 0 of the likelihood.
    const std::uint8_t* likelihood() const { return likelihood_.data(); }
    /// Its best over `rows` cells, from the one asked for upward.
    const std::uint8_t* best_of_rows() const { return best_of_rows_.data(); }
    /// Its best over `block` x `block` cells, from the one asked for to the right and upward.
    const std::uint8_t* best_of_block() const { return best_of_block_.data(); }

 private:
    void size(const std::vector<std::vector<CellIndex>>& cells, int cells_x, int cells_y);
    bool is_small() const;
    void mark(const std::vector<std::vector<CellIndex>>& cells, int cells_x, int cells_y);
    /// Whether the map has nothing in a tile, nor in those to the right and above it that its bounds look at.
    bool is_empty(int tile_x, int tile_y) const;
    void fill(const ScanGrid& grid, int tile_x, int tile_y);
    void bound_rows(int tile_x, int tile_y);
    void bound(int tile_x, int tile_y);

    int x0_ = 0, y0_ = 0, tiles_x_ = 0,
        tiles_y_ = 0;  ///< corner, on a tile's corner, and size, one more tile to the right and above
    std::int32_t stride_ = 0;
    bool has_blocks_ = false;
    static constexpr std::uint8_t needed = 1,
                                  known = 2;  ///< what a tile is: asked for by the search; in the map
    std::vector<std::uint8_t> state_;
    std::vector<std::uint8_t> likelihood_, best_of_rows_, best_of_block_;
};

}  // namespace loopline::grid_map
