#include "lidar_odometry/kd_tree.h"

#include <algorithm>

namespace loopline::lidar_odometry {

void KdTree::build(const std::vector<Eigen::Vector3f>& points_m, std::size_t begin, std::size_t end) {
    entries_.clear();
    nodes_.clear();
    for (std::size_t i = begin; i < end; ++i)
        entries_.push_back({points_m[i], static_cast<std::uint32_t>(i)});
    if (!entries_.empty()) split(0, static_cast<std::uint32_t>(entries_.size()));
}

/// Halves the points along the axis on which they lie farthest apart.
void KdTree::split(std::uint32_t begin, std::uint32_t end) {
    constexpr std::uint32_t most_in_leaf = 10;
    const std::size_t place = nodes_.size();
    nodes_.emplace_back();
    if (end - begin <= most_in_leaf) {
        nodes_[place].begin = begin;
        nodes_[place].end = end;
        return;
    }
    Eigen::Array3f least = entries_[begin].p_m, most = least;
    for (std::uint32_t k = begin + 1; k < end; ++k) {
        least = least.min(entries_[k].p_m.array());
        most = most.max(entries_[k].p_m.array());
    }
    Eigen::Index axis = 0;
    (most - least).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(entries_.begin() + begin, entries_.begin() + middle, entries_.begin() + end,
                     [axis](const Entry& a, const Entry& b) {
                         return a.p_m[axis] < b.p_m[axis] ||
                                (a.p_m[axis] == b.p_m[axis] && a.index < b.index);
                     });
    nodes_[place].axis = static_cast<std::int8_t>(axis);
    nodes_[place].split_m = entries_[middle].p_m[axis];
    split(begin, middle);
    nodes_[place].right = static_cast<std::uint32_t>(nodes_.size());
    split(middle, end);
}

}  // namespace loopline::lidar_odometry
