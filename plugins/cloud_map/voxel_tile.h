/// Part of a map in memory: cubes of space, and where in each of them its one point is, be that in the map
/// already or not yet decided on.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace loopline::cloud_map {

/// Whole numbers of some cube's edge.
using CubeIndex = std::array<std::int32_t, 3>;

constexpr std::uint64_t pack(const CubeIndex& index) {
    constexpr std::uint64_t mask = (std::uint64_t{1} << 21) - 1;
    return (static_cast<std::uint64_t>(index[0]) & mask) << 42 |
           (static_cast<std::uint64_t>(index[1]) & mask) << 21 |
           (static_cast<std::uint64_t>(index[2]) & mask);
}

/// Where in its voxel a point is: in the middle of one of `offset_parts` of the edge along each axis.
using VoxelOffset = std::array<std::uint8_t, 3>;
constexpr int offset_parts = 256;

/// The point of a voxel on which is not decided yet.
struct Candidate {
    std::uint32_t time_ticks = 0;        ///< as CloudPoint's
    std::uint32_t view = 0;              ///< number of the view that comes next after the point
    std::uint16_t intensity = 0;         ///< as CloudPoint's
    std::uint16_t place = 0;             ///< of the voxel in its block
    std::uint8_t seen = 0, through = 0;  ///< views that say so
};

/// 8 x 8 x 8 voxels: two bits for each; where the point is in those that are taken, the candidates, and where
/// later views doubt a point that a voxel has given, a byte for each of those; all in the order of their
/// places.
class Block {
 public:
    static constexpr int edge = 8, voxels = edge * edge * edge;
    /// Of a voxel along each axis, from the block's corner.
    using Local = std::array<int, 3>;

    Block() = default;
    explicit Block(const CubeIndex& i) : index(i) {}

    CubeIndex index{};  ///< in units of a block's edge

    /// Whether a voxel has given its point to the map, or holds a candidate.
    bool is_taken(unsigned place) const { return (taken(place / 64) >> (place % 64) & 1) != 0; }
    /// Of a voxel that is taken.
    const VoxelOffset& offset_of(unsigned place) const { return offsets_[before(place)]; }
    /// Whether a point or candidate is nearer than a voxel's edge to a place: in voxel `at`, of this block or
    /// next to it, so from -1 to 8 along each axis.
    bool has_nearer(const Local& at, const VoxelOffset& offset) const;

    /// Of a voxel that is not taken.
    void hold(const Candidate& candidate, const VoxelOffset& offset);
    void give(unsigned place, const VoxelOffset& offset);
    /// A bit for each voxel that has given its point.
    using Bits = std::array<std::uint64_t, voxels / 64>;
    const Bits& given() const { return given_; }
    static unsigned count(const Bits& bits);
    /// Calls `use(place, offset)` for each voxel that has given its point, in the order of their places.
    template <class Use>
    void for_each_given(const Use& use) const {
        for (unsigned w = 0; w < given_.size(); ++w)
            for (std::uint64_t left = given_[w]; left != 0; left &= left - 1) {
                const unsigned place = 64 * w + lowest(left);
                use(place, offset_of(place));
            }
    }
    /// As given() was, in a block without any, with the offsets of those voxels in the order of their places;
    /// nothing is in doubt.
    void give_all(const Bits& given, std::vector<VoxelOffset> offsets);

    const std::vector<Candidate>& candidates() const { return candidates_; }
    std::size_t points_given() const { return points_given_; }
    /// Whether a view looked through a point that was given, and others have not outvoted it since.
    bool is_doubted() const { return !doubts_.empty(); }
    /// The voxels that have given their points lie in a box, from `first` to `last` along each axis; there is
    /// one at least.
    struct Box {
        std::array<int, 3> first, last;
    };
    Box box_of_given() const;
    /// `look(place, doubt)` may change how many more views have looked through a point than saw something
    /// there, and says whether it stays; if not, its voxel is free again.
    template <class Look>
    void look_again(const Look& look) {
        doubts_.resize(points_given_, 0);
        std::size_t k = 0, kept = 0;
        bool is_doubted = false;
        for (std::size_t w = 0; w < given_.size(); ++w)
            for (std::uint64_t left = given_[w]; left != 0; left &= left - 1, ++k) {
                const auto place = static_cast<unsigned>(64 * w) + lowest(left);
                if (!look(place, doubts_[k])) {
                    free(place);
                    given_[w] &= ~bit(place);
                    continue;
                }
                is_doubted |= doubts_[k] > 0;
                doubts_[kept++] = doubts_[k];
            }
        points_given_ = static_cast<std::uint16_t>(kept);
        doubts_.resize(kept);
        if (!is_doubted) std::vector<std::uint8_t>().swap(doubts_);
    }
    /// `judge(candidate)` may change its counts and says what becomes of each.
    enum class Fate { stays, given, dropped };
    template <class Judge>
    void judge(const Judge& judge) {
        std::size_t kept = 0;
        for (Candidate& candidate : candidates_) {
            const Fate fate = judge(candidate);
            if (fate == Fate::stays) {
                candidates_[kept++] = candidate;
                continue;
            }
            if (fate == Fate::dropped) free(candidate.place);
            held_[candidate.place / 64] &= ~bit(candidate.place);
            if (fate == Fate::given) note_given(candidate.place);
        }
        candidates_.resize(kept);
        if (kept <= candidates_.capacity() / 2) candidates_.shrink_to_fit();
    }

 private:
    template <class Archive>
    friend void fields(Archive&, Block&);
    static std::uint64_t bit(unsigned place) { return std::uint64_t{1} << (place % 64); }
    static unsigned lowest(std::uint64_t bits) { return static_cast<unsigned>(__builtin_ctzll(bits)); }
    static unsigned highest(std::uint64_t bits) { return 63 - static_cast<unsigned>(__builtin_clzll(bits)); }
    /// How many bits of lower places are set.
    static int before(const Bits& bits, unsigned place);
    std::uint64_t taken(unsigned word) const { return given_[word] | held_[word]; }
    /// How many voxels of lower places are taken.
    unsigned before(unsigned place) const {
        return before_word_[place / 64] +
               static_cast<unsigned>(__builtin_popcountll(taken(place / 64) & (bit(place) - 1)));
    }
    void take(unsigned place, const VoxelOffset& offset);
    void free(unsigned place);
    void note_given(unsigned place);

    Bits given_{}, held_{};
    std::array<std::uint16_t, voxels / 64> before_word_{};  ///< how many voxels are taken before each word
    std::uint16_t points_given_ = 0;
    std::vector<VoxelOffset> offsets_;
    std::vector<std::uint8_t> doubts_;  ///< empty: there is none
    std::vector<Candidate> candidates_;
};

/// Blocks of an upright column of space.
class Tile {
 public:
    /// The block, made if it is new. It stays where it is.
    Block& block(const CubeIndex& index);
    /// Null: there is none.
    Block* find(const CubeIndex& index);
    std::deque<Block>& blocks() { return blocks_; }
    const std::deque<Block>& blocks() const { return blocks_; }

 private:
    template <class Archive>
    friend void fields(Archive&, Tile&);
    /// That of a block, or the free one where it would be noted; there are some.
    std::uint32_t& slot_of(const CubeIndex& index);
    /// Twice as many as blocks, or more; those that are there are noted anew.
    void make_slots();

    std::deque<Block> blocks_;  ///< in the order in which they were first met
    /// Numbers of blocks from 1 on, each in the next free slot from its hash on; 0: free.
    std::vector<std::uint32_t> slots_;
};

}  // namespace loopline::cloud_map
