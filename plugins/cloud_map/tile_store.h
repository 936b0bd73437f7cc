/// The map as it grows on disk, and where in it the points of each part of space are.
#pragma once

#include <map>

#include "api/stored_cloud.h"
#include "cloud_map/voxel_tile.h"

namespace loopline::cloud_map {

/// Points are appended and never touched again. For each tile, memory holds a single number.
class TileStore {
 public:
    using TileIndex = std::array<std::int32_t, 2>;

    void keep_in(const std::filesystem::path& folder, const std::string& name) {
        cloud_.keep_in(folder, name + "_points");
        stretches_.keep_in(folder, name + "_stretches");
    }
    void append(const TileIndex& tile, const std::vector<CloudPoint>& points);
    /// Calls `use(point)` with all points of a tile so far, the latest stretch first.
    template <class Use>
    void for_each_of(const TileIndex& tile, const Use& use) const {
        const auto found = last_stretch_.find(tile);
        if (found == last_stretch_.end()) return;
        for (std::uint64_t s = found->second; s != no_stretch;) {
            const Stretch stretch = stretches_[s];
            cloud_.points().for_each(stretch.first, stretch.first + stretch.count, use);
            s = stretch.before;
        }
    }
    StoredCloud& cloud() { return cloud_; }
    const StoredCloud& cloud() const { return cloud_; }

 private:
    template <class Archive>
    friend void fields(Archive&, TileStore&);
    static constexpr std::uint64_t no_stretch = ~std::uint64_t{0};
    /// Points of one tile that were appended together.
    struct Stretch {
        std::uint64_t first = 0, count = 0;
        std::uint64_t before = no_stretch;  ///< the stretch of the same tile before this one
    };
    StoredCloud cloud_;
    SetAside<Stretch> stretches_;
    std::map<TileIndex, std::uint64_t> last_stretch_;
};

}  // namespace loopline::cloud_map
