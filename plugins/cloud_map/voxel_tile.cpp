#include "cloud_map/voxel_tile.h"

#include <algorithm>

namespace loopline::cloud_map {

int Block::before(const Bits& bits, unsigned place) {
    const unsigned word = place / 64;
    int count = __builtin_popcountll(bits[word] & (bit(place) - 1));
    for (unsigned w = 0; w < word; ++w) count += __builtin_popcountll(bits[w]);
    return count;
}

void Block::hold(const Candidate& candidate) {
    candidates_.insert(candidates_.begin() + before(held_, candidate.place), candidate);
    held_[candidate.place / 64] |= bit(candidate.place);
}

void Block::give(unsigned place, std::uint8_t certainty) {
    if ((given_[place / 64] & bit(place)) != 0) return;
    certainty_.insert(certainty_.begin() + before(given_, place), certainty);
    given_[place / 64] |= bit(place);
}

std::uint8_t Block::least_certainty() const {
    std::uint8_t least = 255;
    for (const std::uint8_t certainty : certainty_) least = std::min(least, certainty);
    return least;
}

Block& Tile::block(const CubeIndex& index) {
    const auto [found, is_new] =
        place_of_.try_emplace(pack(index), static_cast<std::uint32_t>(blocks_.size()));
    if (is_new) blocks_.emplace_back(index);
    return blocks_[found->second];
}

}  // namespace loopline::cloud_map
