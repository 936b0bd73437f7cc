#include "grid_map/search_area.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace loopline::grid_map {
namespace {

constexpr int bits = SparseArray<std::uint8_t>::tile_bits, side = SparseArray<std::uint8_t>::tile_side;
/// What the bounds of a tile look at: as far as a block reaches beyond it.
constexpr int wide = side + SearchArea::block;

std::size_t index(int y, int stride, int x) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(x);
}

constexpr int bytes_at_once = 16;
using SomeBytes = std::uint8_t __attribute__((vector_size(bytes_at_once)));

/// to[k] = max(a[k], b[k]).
template <int count>
void larger(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* to) {
    static_assert(count % bytes_at_once == 0);
    for (int k = 0; k < count; k += bytes_at_once) {
        SomeBytes from_a, from_b;
        std::memcpy(&from_a, a + k, bytes_at_once);
        std::memcpy(&from_b, b + k, bytes_at_once);
        from_a = from_a > from_b ? from_a : from_b;
        std::memcpy(to + k, &from_a, bytes_at_once);
    }
}

}  // namespace

SearchArea* SearchArea::around(const ScanGrid& grid, const std::vector<std::vector<CellIndex>>& cells,
                               int cells_x, int cells_y) {
    thread_local SearchArea area;
    area.size(cells, cells_x, cells_y);
    if (!area.is_small()) return nullptr;
    area.stride_ = area.tiles_x_ * side;
    area.has_blocks_ = 2 * std::max(cells_x, cells_y) + 1 > block;
    const std::size_t tiles =
        static_cast<std::size_t>(area.tiles_x_) * static_cast<std::size_t>(area.tiles_y_);
    area.state_.assign(tiles, 0);
    // What is not needed is not written, and whatever is in it is not read.
    if (area.likelihood_.size() < tiles * side * side)
        for (auto* layer : {&area.likelihood_, &area.best_of_rows_, &area.best_of_block_})
            layer->resize(tiles * side * side);
    area.mark(cells, cells_x, cells_y);
    const auto is_needed = [&](int tx, int ty) {
        return tx >= 0 && ty >= 0 && (area.state_[index(ty, area.tiles_x_, tx)] & SearchArea::needed) != 0;
    };
    for (int ty = 0; ty < area.tiles_y_; ++ty)
        for (int tx = 0; tx < area.tiles_x_; ++tx)
            if (is_needed(tx, ty) || is_needed(tx - 1, ty) || is_needed(tx, ty - 1) ||
                is_needed(tx - 1, ty - 1))
                area.fill(grid, tx, ty);
    for (int ty = 0; ty < area.tiles_y_; ++ty)
        for (int tx = 0; tx < area.tiles_x_; ++tx)
            if (is_needed(tx, ty)) area.bound(tx, ty);
    return &area;
}

void SearchArea::size(const std::vector<std::vector<CellIndex>>& cells, int cells_x, int cells_y) {
    int left = std::numeric_limits<int>::max(), bottom = left, right = std::numeric_limits<int>::min(),
        top = right;
    for (const auto& turned : cells)
        for (const CellIndex& cell : turned) {
            left = std::min(left, cell.x);
            right = std::max(right, cell.x);
            bottom = std::min(bottom, cell.y);
            top = std::max(top, cell.y);
        }
    if (left > right) left = right = bottom = top = 0;
    const int first_tx = (left - cells_x) >> bits, first_ty = (bottom - cells_y) >> bits;
    x0_ = first_tx * side;
    y0_ = first_ty * side;
    tiles_x_ = ((right + cells_x + block) >> bits) - first_tx + 2;
    tiles_y_ = ((top + cells_y + block) >> bits) - first_ty + 2;
}

bool SearchArea::is_small() const {
    constexpr std::int64_t most_tiles = 1 << 16;  // 64 MB
    return static_cast<std::int64_t>(tiles_x_) * tiles_y_ <= most_tiles;
}

void SearchArea::mark(const std::vector<std::vector<CellIndex>>& cells, int cells_x, int cells_y) {
    // A return hardly moves from one heading to the next, so a few of them are taken together.
    constexpr std::size_t together = 8;
    for (std::size_t first = 0; first < cells.size(); first += together) {
        const std::size_t end = std::min(first + together, cells.size());
        for (std::size_t i = 0; i < cells[first].size(); ++i) {
            int left = cells[first][i].x, right = left, bottom = cells[first][i].y, top = bottom;
            for (std::size_t k = first + 1; k < end; ++k) {
                left = std::min(left, cells[k][i].x);
                right = std::max(right, cells[k][i].x);
                bottom = std::min(bottom, cells[k][i].y);
                top = std::max(top, cells[k][i].y);
            }
            for (int ty = (bottom - cells_y - y0_) >> bits; ty <= (top + cells_y + block - 1 - y0_) >> bits;
                 ++ty)
                for (int tx = (left - cells_x - x0_) >> bits;
                     tx <= (right + cells_x + block - 1 - x0_) >> bits; ++tx)
                    state_[index(ty, tiles_x_, tx)] |= needed;
        }
    }
}

bool SearchArea::is_empty(int tile_x, int tile_y) const {
    const std::size_t stride = static_cast<std::size_t>(tiles_x_), at = index(tile_y, tiles_x_, tile_x);
    return ((state_[at] | state_[at + 1] | state_[at + stride] | state_[at + stride + 1]) & known) == 0;
}

void SearchArea::fill(const ScanGrid& grid, int tile_x, int tile_y) {
    const int x0 = x0_ + tile_x * side, y0 = y0_ + tile_y * side;
    // A tile's rows lie one after another.
    const std::uint8_t* tile = grid.likelihood_layer(0).find(x0, y0);
    if (tile != nullptr) state_[index(tile_y, tiles_x_, tile_x)] |= known;
    for (int y = 0; y < side; ++y) {
        std::uint8_t* row = &likelihood_[index(tile_y * side + y, stride_, tile_x * side)];
        if (tile != nullptr)
            std::memcpy(row, tile + y * side, side);
        else
            std::memset(row, 0, side);
    }
}

void SearchArea::bound_rows(int tile_x, int tile_y) {
    const auto row = [&](std::vector<std::uint8_t>& layer, int y) {
        return &layer[index(tile_y * side + y, stride_, tile_x * side)];
    };
    std::uint8_t best_2[(side + 2) * side];
    for (int y = 0; y < side + 2; ++y)
        larger<side>(row(likelihood_, y), row(likelihood_, y + 1), best_2 + y * side);
    for (int y = 0; y < side; ++y)
        larger<side>(best_2 + y * side, best_2 + (y + 2) * side, row(best_of_rows_, y));
}

void SearchArea::bound(int tile_x, int tile_y) {
    static_assert(rows == 4 && block == 16 && wide == 48);
    if (is_empty(tile_x, tile_y)) {
        for (int y = 0; y < side; ++y)
            for (auto* layer : {&best_of_rows_, &best_of_block_})
                std::memset(&(*layer)[index(tile_y * side + y, stride_, tile_x * side)], 0, side);
        return;
    }
    if (!has_blocks_) return bound_rows(tile_x, tile_y);
    const std::uint8_t* from = &likelihood_[index(tile_y * side, stride_, tile_x * side)];
    // Best of 2, 4, 8 and 16 rows; from the bottom to the top, since each looks at those above it only.
    std::uint8_t best[wide * wide];
    const auto row = [&best](int y) { return best + y * wide; };
    for (int y = 0; y < wide - 1; ++y)
        larger<wide>(from + index(y, stride_, 0), from + index(y + 1, stride_, 0), row(y));
    for (int y = 0; y < wide - 3; ++y) larger<wide>(row(y), row(y + 2), row(y));
    for (int y = 0; y < side; ++y)
        std::memcpy(&best_of_rows_[index(tile_y * side + y, stride_, tile_x * side)], row(y), side);
    for (int y = 0; y < wide - 8; ++y) larger<wide>(row(y), row(y + 4), row(y));
    for (int y = 0; y < side; ++y) {
        std::uint8_t beside[wide + bytes_at_once] = {};
        larger<wide>(row(y), row(y + 8), beside);
        // The same for cells beside each other, from left to right.
        larger<wide>(beside, beside + 1, beside);
        larger<wide>(beside, beside + 2, beside);
        larger<wide>(beside, beside + 4, beside);
        larger<side>(beside, beside + 8, &best_of_block_[index(tile_y * side + y, stride_, tile_x * side)]);
    }
}

}  // namespace loopline::grid_map
