/// The map as it grows on disk, and where in it the points of each part of space are.
#pragma once

#include <map>
#include <unordered_set>

#include "api/stored_cloud.h"
#include "cloud_map/voxel_tile.h"

namespace loopline::cloud_map {

/// What is written is never touched again: a point that is gone is noted in a file of its own, and left out
/// when the cloud is complete. Two more hold the voxels that are taken of each tile that is not in memory,
/// and where in them the points are. For each tile, memory holds four numbers.
class TileStore {
 public:
    using TileIndex = std::array<std::int32_t, 2>;

    explicit TileStore(double voxel_m) : voxel_m_(voxel_m) {}

    void keep_in(const std::filesystem::path& folder, const std::string& name);
    /// What is new of a tile: points, and voxels, packed, whose points of before are gone.
    void append(const TileIndex& tile, const std::vector<CloudPoint>& points,
                const std::vector<std::uint64_t>& gone);
    /// Notes which voxels of a tile have given their points, and where those are, which memory forgets until
    /// the vehicle comes back.
    void put_away(const TileIndex& index, const Tile& tile);
    void bring_back(const TileIndex& index, Tile& tile) const;
    /// Calls `use(point)` with all points of a tile that are still there, the latest stretch first.
    template <class Use>
    void for_each_of(const TileIndex& tile, const Use& use) const {
        const auto found = last_stretch_.find(tile);
        if (found == last_stretch_.end()) return;
        std::unordered_set<std::uint64_t> gone;  // whose point is in a stretch before
        for (std::uint64_t s = found->second; s != no_stretch;) {
            const Stretch stretch = stretches_[s];
            cloud_.points().for_each(stretch.first, stretch.first + stretch.count,
                                     [&](const CloudPoint& point) {
                                         if (gone.empty() || gone.erase(pack(voxel_of(point))) == 0)
                                             use(point);
                                     });
            gone_.for_each(stretch.first_gone, stretch.first_gone + stretch.gone_count,
                           [&](std::uint64_t voxel) { gone.insert(voxel); });
            s = stretch.before;
        }
    }
    CubeIndex voxel_of(const CloudPoint& point) const;
    /// Nothing is appended any more: makes a cloud of what is still there, tile by tile.
    void leave_out_what_is_gone();

    StoredCloud& cloud() { return cloud_; }
    const StoredCloud& cloud() const { return cloud_; }

 private:
    template <class Archive>
    friend void fields(Archive&, TileStore&);
    static constexpr std::uint64_t no_stretch = ~std::uint64_t{0};
    /// What was appended of one tile together. Nothing that is gone is of the same stretch.
    struct Stretch {
        std::uint64_t first = 0, count = 0;
        std::uint64_t first_gone = 0, gone_count = 0;
        std::uint64_t before = no_stretch;  ///< the stretch of the same tile before this one
    };
    struct Taken {
        CubeIndex block{};
        std::int32_t reserved = 0;
        Block::Bits given{};
    };
    /// Of a tile that was put away: in `taken_`, and from where on in `offsets_`.
    struct Place {
        std::uint64_t first = 0, count = 0, first_offset = 0;
    };
    template <class Archive>
    friend void fields(Archive&, Place&);

    double voxel_m_;
    std::filesystem::path folder_;
    std::string name_;
    StoredCloud cloud_;
    SetAside<std::uint64_t> gone_;
    SetAside<Stretch> stretches_;
    std::map<TileIndex, std::uint64_t> last_stretch_;
    SetAside<Taken> taken_;
    SetAside<VoxelOffset> offsets_;  ///< of each voxel in `taken_`, in order
    std::map<TileIndex, Place> place_of_taken_;
};

}  // namespace loopline::cloud_map
