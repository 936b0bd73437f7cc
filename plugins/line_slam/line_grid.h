/// Where in the plane lines are, roughly: which of thousands could be near a place, without looking at all.
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

namespace loopline::line_slam {

class LineGrid {
 public:
    /// Adds the stretch from `a_m` to `b_m` (map frame) of line `id` to what was added before.
    void add(int id, const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m);
    /// Lines with a stretch in some cell that the box touches, ascending: all that are in the box, and some
    /// around it.
    std::vector<int> in_box(const Eigen::Vector2d& least_m, const Eigen::Vector2d& greatest_m) const;

 private:
    template <class Archive>
    friend void fields(Archive&, LineGrid&);
    static constexpr double cell_m = 8;
    using Cell = std::pair<int, int>;
    static Cell cell_of(const Eigen::Vector2d& p_m);
    std::map<Cell, std::vector<int>> cells_;
};

}  // namespace loopline::line_slam
