/// Part of a map in memory: cubes of space that hold one point each, or are known to have given theirs away.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
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

/// The point of a voxel on which is not decided yet.
struct Candidate {
    std::uint32_t time_ticks = 0;          ///< as CloudPoint's
    std::uint32_t view = 0;                ///< number of the view that comes next after the point
    std::uint16_t intensity = 0;           ///< as CloudPoint's
    std::uint16_t place = 0;               ///< of the voxel in its block
    std::array<std::uint8_t, 3> offset{};  ///< in the voxel, in 256 parts of its edge
    std::uint8_t seen = 0, through = 0;    ///< views that say so
};

/// 8 x 8 x 8 voxels: two bits for each, the candidates, and where later views doubt a point that a voxel has
/// given, a byte for each of those; both in the order of their places.
class Block {
 public:
    static constexpr int edge = 8, voxels = edge * edge * edge;

    Block() = default;
    explicit Block(const CubeIndex& i) : index(i) {}

    CubeIndex index{};  ///< in units of a block's edge

    /// Whether a voxel has given its point to the map, or holds a candidate.
    bool is_taken(unsigned place) const {
        return ((given_[place / 64] | held_[place / 64]) >> (place % 64) & 1) != 0;
    }
    void hold(const Candidate& candidate);
    void give(unsigned place);
    /// A bit for each voxel that has given its point.
    using Bits = std::array<std::uint64_t, voxels / 64>;
    const Bits& given() const { return given_; }
    /// As given() was, in a block without any; nothing is in doubt.
    void give_all(const Bits& given);

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
            held_[candidate.place / 64] &= ~bit(candidate.place);
            if (fate == Fate::given) give(candidate.place);
        }
        candidates_.resize(kept);
        if (kept == 0) std::vector<Candidate>().swap(candidates_);
    }

 private:
    template <class Archive>
    friend void fields(Archive&, Block&);
    static std::uint64_t bit(unsigned place) { return std::uint64_t{1} << (place % 64); }
    static unsigned lowest(std::uint64_t bits) { return static_cast<unsigned>(__builtin_ctzll(bits)); }
    static unsigned highest(std::uint64_t bits) { return 63 - static_cast<unsigned>(__builtin_clzll(bits)); }
    /// How many bits of lower places are set.
    static int before(const Bits& bits, unsigned place);

    Bits given_{}, held_{};
    std::uint16_t points_given_ = 0;
    std::vector<std::uint8_t> doubts_;  ///< empty: there is none
    std::vector<Candidate> candidates_;
};

/// Blocks of an upright column of space.
class Tile {
 public:
    /// The block, made if it is new. Valid until the next one is made.
    Block& block(const CubeIndex& index);
    std::vector<Block>& blocks() { return blocks_; }
    const std::vector<Block>& blocks() const { return blocks_; }

 private:
    template <class Archive>
    friend void fields(Archive&, Tile&);
    struct Mix {
        std::size_t operator()(std::uint64_t key) const {
            key = (key ^ key >> 30) * 0xbf58476d1ce4e5b9U;
            key = (key ^ key >> 27) * 0x94d049bb133111ebU;
            return static_cast<std::size_t>(key ^ key >> 31);
        }
    };
    std::vector<Block> blocks_;  ///< in the order in which they were first met
    std::unordered_map<std::uint64_t, std::uint32_t, Mix> place_of_;
};

}  // namespace loopline::cloud_map
