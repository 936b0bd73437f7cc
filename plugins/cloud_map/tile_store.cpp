#include "cloud_map/tile_store.h"

#include <cmath>

namespace loopline::cloud_map {

void TileStore::keep_in(const std::filesystem::path& folder, const std::string& name) {
    folder_ = folder;
    name_ = name;
    cloud_.keep_in(folder, name + "_points");
    gone_.keep_in(folder, name + "_gone");
    stretches_.keep_in(folder, name + "_stretches");
    taken_.keep_in(folder, name + "_taken");
    offsets_.keep_in(folder, name + "_offsets");
}

void TileStore::append(const TileIndex& tile, const std::vector<CloudPoint>& points,
                       const std::vector<std::uint64_t>& gone) {
    if (points.empty() && gone.empty()) return;
    const auto [found, is_new] = last_stretch_.try_emplace(tile, no_stretch);
    const Stretch stretch{cloud_.points().size(), points.size(), gone_.size(), gone.size(), found->second};
    found->second = stretches_.size();
    stretches_.push_back(stretch);
    for (const CloudPoint& point : points) cloud_.push_back(point);
    for (const std::uint64_t voxel : gone) gone_.push_back(voxel);
}

void TileStore::put_away(const TileIndex& index, const Tile& tile) {
    if (tile.blocks().empty()) return;
    Place& place = place_of_taken_[index];
    place.first = taken_.size();
    place.first_offset = offsets_.size();
    for (const Block& block : tile.blocks()) {
        if (block.points_given() == 0) continue;
        taken_.push_back({block.index, 0, block.given()});
        block.for_each_given([&](unsigned, const VoxelOffset& offset) { offsets_.push_back(offset); });
    }
    place.count = taken_.size() - place.first;
}

void TileStore::bring_back(const TileIndex& index, Tile& tile) const {
    const auto found = place_of_taken_.find(index);
    if (found == place_of_taken_.end()) return;
    const Place& place = found->second;
    std::uint64_t first = place.first_offset;
    taken_.for_each(place.first, place.first + place.count, [&](const Taken& taken) {
        const std::uint64_t end = first + Block::count(taken.given);
        std::vector<VoxelOffset> offsets;
        offsets.reserve(end - first);
        offsets_.for_each(first, end, [&](const VoxelOffset& offset) { offsets.push_back(offset); });
        tile.block(taken.block).give_all(taken.given, std::move(offsets));
        first = end;
    });
}

CubeIndex TileStore::voxel_of(const CloudPoint& point) const {
    CubeIndex voxel;
    for (std::size_t axis = 0; axis < 3; ++axis)
        voxel[axis] =
            static_cast<std::int32_t>(std::floor(point.place[axis] * (CloudPoint::unit_m / voxel_m_)));
    return voxel;
}

/// In a new file: a checkpoint may refer to the old one.
void TileStore::leave_out_what_is_gone() {
    if (gone_.empty()) return;
    StoredCloud left;
    left.first_ns = cloud_.first_ns;
    left.has_intensity = cloud_.has_intensity;
    left.keep_in(folder_, name_ + "_left");
    for (const auto& [tile, stretch] : last_stretch_)
        for_each_of(tile, [&](const CloudPoint& point) { left.push_back(point); });
    cloud_ = std::move(left);
}

}  // namespace loopline::cloud_map
