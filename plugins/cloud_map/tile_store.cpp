#include "cloud_map/tile_store.h"

namespace loopline::cloud_map {

void TileStore::append(const TileIndex& tile, const std::vector<CloudPoint>& points) {
    if (points.empty()) return;
    const auto [found, is_new] = last_stretch_.try_emplace(tile, no_stretch);
    const Stretch stretch{cloud_.points().size(), points.size(), found->second};
    found->second = stretches_.size();
    stretches_.push_back(stretch);
    for (const CloudPoint& point : points) cloud_.push_back(point);
}

}  // namespace loopline::cloud_map
