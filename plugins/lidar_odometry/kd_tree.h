/// A k-d tree of points in space that is built once a sweep: the exact nearest point, also among chosen
/// ones. Bentley 1975, "Multidimensional binary search trees used for associative searching".
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace loopline::lidar_odometry {

class KdTree {
 public:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    /// Of the points from index `begin` up to `end`. Keeps its memory from one set of points to the next.
    void build(const std::vector<Eigen::Vector3f>& points_m, std::size_t begin, std::size_t end);
    void build(const std::vector<Eigen::Vector3f>& points_m) { build(points_m, 0, points_m.size()); }

    /// Index of the point nearest to `p_m` among those for which accept(index) is true and that are nearer
    /// than `max_distance_m`; of several equally near ones the first; `none` if there is none.
    template <class Accept>
    std::uint32_t nearest(const Eigen::Vector3f& p_m, float max_distance_m, const Accept& accept) const {
        Search<Accept> search{*this, p_m, accept, max_distance_m * max_distance_m, none};
        if (!nodes_.empty()) search.visit(0, 0, {0, 0, 0});
        return search.best;
    }
    std::uint32_t nearest(const Eigen::Vector3f& p_m, float max_distance_m) const {
        return nearest(p_m, max_distance_m, [](std::uint32_t) { return true; });
    }

 private:
    struct Node {
        float split_m = 0;                 ///< left: not above, right: not below
        std::uint32_t right = 0;           ///< the left child follows its parent
        std::uint32_t begin = 0, end = 0;  ///< of a leaf
        std::int8_t axis = -1;             ///< -1: a leaf
    };
    struct Entry {
        Eigen::Vector3f p_m;
        std::uint32_t index;
    };

    template <class Accept>
    struct Search {
        const KdTree& tree;
        const Eigen::Vector3f& p_m;
        const Accept& accept;
        float best_m2;
        std::uint32_t best;

        /// `beyond_m`: how far the cell lies from the point along each axis, `cell_m2` that squared.
        void visit(std::uint32_t place, float cell_m2, std::array<float, 3> beyond_m) {
            const Node& node = tree.nodes_[place];
            if (node.axis < 0) {
                look_into(node);
                return;
            }
            const auto axis = static_cast<std::size_t>(node.axis);
            const float off_m = p_m[node.axis] - node.split_m;
            const bool left_first = off_m < 0;
            visit(left_first ? place + 1 : node.right, cell_m2, beyond_m);
            const float other_m2 = cell_m2 - beyond_m[axis] * beyond_m[axis] + off_m * off_m;
            if (other_m2 * (1 - 1e-5f) > best_m2) return;  // the sum is rounded
            beyond_m[axis] = off_m;
            visit(left_first ? node.right : place + 1, other_m2, beyond_m);
        }
        void look_into(const Node& leaf) {
            for (std::uint32_t k = leaf.begin; k < leaf.end; ++k) {
                const Entry& entry = tree.entries_[k];
                const float d_m2 = (entry.p_m - p_m).squaredNorm();
                if (d_m2 > best_m2 || (d_m2 == best_m2 && entry.index >= best) || !accept(entry.index))
                    continue;
                best_m2 = d_m2;
                best = entry.index;
            }
        }
    };

    void split(std::uint32_t begin, std::uint32_t end);

    std::vector<Entry> entries_;
    std::vector<Node> nodes_;
};

}  // namespace loopline::lidar_odometry
