#include "cloud_map/voxel_tile.h"

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

void Block::give(unsigned place) {
    if ((given_[place / 64] & bit(place)) != 0) return;
    if (is_doubted()) doubts_.insert(doubts_.begin() + before(given_, place), 0);
    given_[place / 64] |= bit(place);
    ++points_given_;
}

void Block::give_all(const Bits& given) {
    given_ = given;
    int count = 0;
    for (const std::uint64_t word : given) count += __builtin_popcountll(word);
    points_given_ = static_cast<std::uint16_t>(count);
}

/// A place is x y z with three bits each, so a word is a layer across x.
Block::Box Block::box_of_given() const {
    Box box{};
    std::uint64_t layers = 0, of_layers = 0;
    for (std::size_t x = 0; x < given_.size(); ++x) {
        layers |= std::uint64_t{given_[x] != 0} << x;
        of_layers |= given_[x];
    }
    std::uint64_t heights = of_layers | of_layers >> 32;
    heights |= heights >> 16;
    heights = (heights | heights >> 8) & 0xff;
    box.first = {static_cast<int>(lowest(layers)), static_cast<int>(lowest(of_layers) / 8),
                 static_cast<int>(lowest(heights))};
    box.last = {static_cast<int>(highest(layers)), static_cast<int>(highest(of_layers) / 8),
                static_cast<int>(highest(heights))};
    return box;
}

Block& Tile::block(const CubeIndex& index) {
    const auto [found, is_new] =
        place_of_.try_emplace(pack(index), static_cast<std::uint32_t>(blocks_.size()));
    if (is_new) blocks_.emplace_back(index);
    return blocks_[found->second];
}

}  // namespace loopline::cloud_map
