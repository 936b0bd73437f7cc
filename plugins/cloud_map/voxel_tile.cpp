#include "cloud_map/voxel_tile.h"

#include <algorithm>

namespace loopline::cloud_map {
namespace {

constexpr std::size_t offsets_at_once = 8;  // room for so many more: twice as many would mostly stay empty

constexpr std::size_t fewest_slots = 64;  // a power of two

/// As MurmurHash3 (Appleby) ends, with Stafford's variant 13 of its numbers.
std::size_t mixed(std::uint64_t key) {
    key = (key ^ key >> 30) * 0xbf58476d1ce4e5b9U;
    key = (key ^ key >> 27) * 0x94d049bb133111ebU;
    return static_cast<std::size_t>(key ^ key >> 31);
}

/// Of a layer across x, the bits of the 3 x 3 voxels about one at y, z from -1 to 8.
constexpr auto layers_about = [] {
    std::array<std::array<std::uint64_t, Block::edge + 2>, Block::edge + 2> layers{};
    for (int y = -1; y <= Block::edge; ++y)
        for (int z = -1; z <= Block::edge; ++z)
            for (int row = std::max(0, y - 1); row <= std::min(Block::edge - 1, y + 1); ++row)
                for (int k = std::max(0, z - 1); k <= std::min(Block::edge - 1, z + 1); ++k)
                    layers[static_cast<std::size_t>(y + 1)][static_cast<std::size_t>(z + 1)] |=
                        std::uint64_t{1} << (Block::edge * row + k);
    return layers;
}();

}  // namespace

int Block::before(const Bits& bits, unsigned place) {
    const unsigned word = place / 64;
    int count = __builtin_popcountll(bits[word] & (bit(place) - 1));
    for (unsigned w = 0; w < word; ++w) count += __builtin_popcountll(bits[w]);
    return count;
}

unsigned Block::count(const Bits& bits) {
    int count = 0;
    for (const std::uint64_t word : bits) count += __builtin_popcountll(word);
    return static_cast<unsigned>(count);
}

void Block::take(unsigned place, const VoxelOffset& offset) {
    if (offsets_.size() == offsets_.capacity()) offsets_.reserve(offsets_.size() + offsets_at_once);
    offsets_.insert(offsets_.begin() + before(place), offset);
    for (unsigned w = place / 64 + 1; w < before_word_.size(); ++w) ++before_word_[w];
}

void Block::free(unsigned place) {
    offsets_.erase(offsets_.begin() + before(place));
    for (unsigned w = place / 64 + 1; w < before_word_.size(); ++w) --before_word_[w];
}

void Block::hold(const Candidate& candidate, const VoxelOffset& offset) {
    take(candidate.place, offset);
    candidates_.insert(candidates_.begin() + before(held_, candidate.place), candidate);
    held_[candidate.place / 64] |= bit(candidate.place);
}

void Block::give(unsigned place, const VoxelOffset& offset) {
    take(place, offset);
    note_given(place);
}

void Block::note_given(unsigned place) {
    if (is_doubted()) doubts_.insert(doubts_.begin() + before(given_, place), 0);
    given_[place / 64] |= bit(place);
    ++points_given_;
}

void Block::give_all(const Bits& given, std::vector<VoxelOffset> offsets) {
    given_ = given;
    offsets_ = std::move(offsets);
    points_given_ = 0;
    for (std::size_t w = 0; w < given.size(); ++w) {
        before_word_[w] = points_given_;
        points_given_ = static_cast<std::uint16_t>(points_given_ + __builtin_popcountll(given[w]));
    }
}

bool Block::has_nearer(const Local& at, const VoxelOffset& offset) const {
    const std::uint64_t about =
        layers_about[static_cast<std::size_t>(at[1] + 1)][static_cast<std::size_t>(at[2] + 1)];
    for (int x = std::max(0, at[0] - 1); x <= std::min(edge - 1, at[0] + 1); ++x) {
        const std::uint64_t of_layer = taken(static_cast<unsigned>(x));
        for (std::uint64_t left = of_layer & about; left != 0; left &= left - 1) {
            const auto lower = (left & (~left + 1)) - 1;
            const unsigned in_layer = lowest(left);
            const VoxelOffset& there =
                offsets_[before_word_[static_cast<std::size_t>(x)] +
                         static_cast<unsigned>(__builtin_popcountll(of_layer & lower))];
            const int dx = (x - at[0]) * offset_parts + there[0] - offset[0],
                      dy = (static_cast<int>(in_layer / edge) - at[1]) * offset_parts + there[1] - offset[1],
                      dz = (static_cast<int>(in_layer % edge) - at[2]) * offset_parts + there[2] - offset[2];
            if (dx * dx + dy * dy + dz * dz < offset_parts * offset_parts) return true;
        }
    }
    return false;
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

std::uint32_t& Tile::slot_of(const CubeIndex& index) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t s = mixed(pack(index)) & mask;
    while (slots_[s] != 0 && blocks_[slots_[s] - 1].index != index) s = (s + 1) & mask;
    return slots_[s];
}

void Tile::make_slots() {
    std::size_t count = fewest_slots;
    while (count < 2 * blocks_.size()) count *= 2;
    slots_.assign(count, 0);
    for (std::uint32_t k = 0; k < blocks_.size(); ++k) slot_of(blocks_[k].index) = k + 1;
}

Block& Tile::block(const CubeIndex& index) {
    if (Block* there = find(index)) return *there;
    blocks_.emplace_back(index);
    if (slots_.size() < 2 * blocks_.size())
        make_slots();
    else
        slot_of(index) = static_cast<std::uint32_t>(blocks_.size());
    return blocks_.back();
}

Block* Tile::find(const CubeIndex& index) {
    if (slots_.empty()) return nullptr;
    const std::uint32_t number = slot_of(index);
    return number == 0 ? nullptr : &blocks_[number - 1];
}

}  // namespace loopline::cloud_map
