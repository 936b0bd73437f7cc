#include "cloud_localisation/upright_columns.h"

#include <algorithm>
#include <utility>

namespace loopline::cloud_localisation {

using lidar_mapping::no_voxel;
using lidar_mapping::pack;
using lidar_mapping::VoxelKey;

/// That of the key, or the free one where it belongs.
std::size_t UprightColumns::slot_of(VoxelKey key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t k = lidar_mapping::hash(key) & mask;
    while (slots_[k].key != key && slots_[k].key != no_voxel) k = (k + 1) & mask;
    return k;
}

void UprightColumns::grow() {
    std::vector<Column> before(2 * slots_.size());
    std::swap(before, slots_);
    for (const Column& column : before)
        if (column.key != no_voxel) slots_[slot_of(column.key)] = column;
}

void UprightColumns::add(const Eigen::Vector3d& p_m) {
    const VoxelKey key = pack({index_of(p_m.x()), index_of(p_m.y()), 0});
    const auto z_m = static_cast<float>(p_m.z());
    Column* column = &slots_[slot_of(key)];
    if (column->key == no_voxel) {
        if (10 * (count_ + 1) > 6 * slots_.size()) {
            grow();
            column = &slots_[slot_of(key)];
        }
        ++count_;
        *column = {key, z_m, z_m};
        return;
    }
    column->low_m = std::min(column->low_m, z_m);
    column->high_m = std::max(column->high_m, z_m);
}

const UprightColumns::Column* UprightColumns::find(int x, int y) const {
    const Column& column = slots_[slot_of(pack({x, y, 0}))];
    return column.key == no_voxel ? nullptr : &column;
}

void UprightColumns::clear() {
    slots_.assign(slots_.size(), {});
    count_ = 0;
}

}  // namespace loopline::cloud_localisation
