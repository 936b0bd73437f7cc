#include "cloud_map/voxel_tile.h"

namespace loopline::cloud_map {

/// Behind those at lower places: their number is counted in the bits.
void Block::hold(const Candidate& candidate) {
    const unsigned word = candidate.place / 64;
    int before = __builtin_popcountll(held_[word] & (bit(candidate.place) - 1));
    for (unsigned w = 0; w < word; ++w) before += __builtin_popcountll(held_[w]);
    candidates_.insert(candidates_.begin() + before, candidate);
    held_[word] |= bit(candidate.place);
}

Block& Tile::block(const CubeIndex& index) {
    const auto [found, is_new] =
        place_of_.try_emplace(pack(index), static_cast<std::uint32_t>(blocks_.size()));
    if (is_new) blocks_.emplace_back(index);
    return blocks_[found->second];
}

}  // namespace loopline::cloud_map
