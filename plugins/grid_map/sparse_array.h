/// A plane of cells that takes memory only where something is in it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <utility>

namespace loopline::grid_map {

/// Cells by whole numbers of any size, all zero (T{}) at first. Kept in tiles of 32 x 32 cells, and pointers
/// to these in blocks of 64 x 64, so that reading costs two steps and memory grows with the area in use, not
/// with its bounding box.
template <class T>
class SparseArray {
 public:
    static constexpr int tile_bits = 5, block_bits = 6;
    static constexpr int tile_side = 1 << tile_bits, block_side = 1 << block_bits;
    using Tile = std::array<T, tile_side * tile_side>;

    SparseArray() = default;
    SparseArray(const SparseArray&) = delete;
    SparseArray& operator=(const SparseArray&) = delete;

    /// Null where nothing was ever written nearby.
    const T* find(int x, int y) const {
        const Tile* tile = find_tile(x >> tile_bits, y >> tile_bits);
        return tile != nullptr ? &(*tile)[cell_in_tile(x, y)] : nullptr;
    }
    T value(int x, int y) const {
        const T* cell = find(x, y);
        return cell != nullptr ? *cell : T{};
    }
    /// For writing.
    T& at(int x, int y) {
        const int tx = x >> tile_bits, ty = y >> tile_bits;
        Block& block = block_of(tx >> block_bits, ty >> block_bits);
        auto& tile = block[tile_in_block(tx, ty)];
        if (tile == nullptr) {
            tile = std::make_unique<Tile>();
            tile->fill(T{});
            ++tiles_;
        }
        return (*tile)[cell_in_tile(x, y)];
    }

    /// The cells (x0, y) .. (x0 + count - 1, y) for writing: visit(x, cells, count) for each part in one
    /// tile.
    template <class Visit>
    void write_row(int x0, int y, int count, const Visit& visit) {
        for (int x = x0; x < x0 + count;) {
            const int end = std::min(x0 + count, (x | (tile_side - 1)) + 1);
            visit(x, &at(x, y), end - x);
            x = end;
        }
    }

    /// visit(cell) for the cells (x, y), (x - 1, y), (x, y - 1) and (x - 1, y - 1), for writing.
    template <class Visit>
    void write_square(int x, int y, const Visit& visit) {
        T* cell = &at(x, y);
        visit(*cell);
        const bool in_one_tile = (x & (tile_side - 1)) > 0 && (y & (tile_side - 1)) > 0;
        visit(in_one_tile ? cell[-1] : at(x - 1, y));
        visit(in_one_tile ? cell[-tile_side] : at(x, y - 1));
        visit(in_one_tile ? cell[-tile_side - 1] : at(x - 1, y - 1));
    }

    /// visit(x, y, cell) for the cells from (x0, y0) to (x1, y1), both included, that are in a tile; row by
    /// row within each tile.
    template <class Visit>
    void visit_window(int x0, int y0, int x1, int y1, const Visit& visit) const {
        for (int ty = y0 >> tile_bits; ty <= y1 >> tile_bits; ++ty)
            for (int tx = x0 >> tile_bits; tx <= x1 >> tile_bits; ++tx) {
                const Tile* tile = find_tile(tx, ty);
                if (tile == nullptr) continue;
                const int left = std::max(x0, tx * tile_side),
                          right = std::min(x1, tx * tile_side + tile_side - 1),
                          bottom = std::max(y0, ty * tile_side),
                          top = std::min(y1, ty * tile_side + tile_side - 1);
                for (int y = bottom; y <= top; ++y) {
                    const T* row = &(*tile)[cell_in_tile(left, y)];
                    for (int x = left; x <= right; ++x) visit(x, y, row[x - left]);
                }
            }
    }

    std::size_t tiles() const { return tiles_; }
    /// Of tiles and blocks.
    std::size_t bytes() const { return tiles_ * sizeof(Tile) + blocks_.size() * sizeof(Block); }

    /// visit(x, y, cell) for each cell of each tile, in an order that depends on nothing but which tiles
    /// there are.
    template <class Visit>
    void for_each(const Visit& visit) const {
        for (const auto& [key, block] : blocks_)
            for (int t = 0; t < block_side * block_side; ++t) {
                const auto& tile = (*block)[static_cast<std::size_t>(t)];
                if (tile == nullptr) continue;
                const int x0 = (key.first * block_side + t % block_side) * tile_side,
                          y0 = (key.second * block_side + t / block_side) * tile_side;
                for (int c = 0; c < tile_side * tile_side; ++c)
                    visit(x0 + c % tile_side, y0 + c / tile_side, (*tile)[static_cast<std::size_t>(c)]);
            }
    }

    /// Gives back the tiles that hold nothing but T{}.
    void drop_empty_tiles() {
        latest_ = nullptr;
        for (auto block = blocks_.begin(); block != blocks_.end();) {
            bool any = false;
            for (auto& tile : *block->second) {
                if (tile == nullptr) continue;
                if (std::all_of(tile->begin(), tile->end(), [](const T& cell) { return cell == T{}; })) {
                    tile.reset();
                    --tiles_;
                } else {
                    any = true;
                }
            }
            block = any ? std::next(block) : blocks_.erase(block);
        }
    }

 private:
    using Block = std::array<std::unique_ptr<Tile>, block_side * block_side>;

    static std::size_t cell_in_tile(int x, int y) {
        return static_cast<std::size_t>(((y & (tile_side - 1)) << tile_bits) | (x & (tile_side - 1)));
    }
    static std::size_t tile_in_block(int tx, int ty) {
        return static_cast<std::size_t>(((ty & (block_side - 1)) << block_bits) | (tx & (block_side - 1)));
    }
    const Tile* find_tile(int tx, int ty) const {
        const int bx = tx >> block_bits, by = ty >> block_bits;
        if (latest_ == nullptr || bx != latest_x_ || by != latest_y_) {
            const auto found = blocks_.find({bx, by});
            if (found == blocks_.end()) return nullptr;
            remember(bx, by, *found->second);
        }
        return (*latest_)[tile_in_block(tx, ty)].get();
    }
    Block& block_of(int bx, int by) {
        if (latest_ == nullptr || bx != latest_x_ || by != latest_y_) {
            auto& block = blocks_[{bx, by}];
            if (block == nullptr) block = std::make_unique<Block>();
            remember(bx, by, *block);
        }
        return *latest_;
    }
    void remember(int bx, int by, Block& block) const {
        latest_ = &block;
        latest_x_ = bx;
        latest_y_ = by;
    }

    std::map<std::pair<int, int>, std::unique_ptr<Block>> blocks_;
    std::size_t tiles_ = 0;
    mutable Block* latest_ =
        nullptr;  ///< the block that was asked for last, as nearly all questions in a row are for one
    mutable int latest_x_ = 0, latest_y_ = 0;
};

/// Whether all cells are equal, whatever tiles there are.
template <class T>
bool operator==(const SparseArray<T>& a, const SparseArray<T>& b) {
    bool same = true;
    a.for_each([&](int x, int y, const T& cell) { same = same && cell == b.value(x, y); });
    b.for_each([&](int x, int y, const T& cell) { same = same && cell == a.value(x, y); });
    return same;
}

}  // namespace loopline::grid_map
