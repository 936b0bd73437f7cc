#include "line_slam/line_grid.h"

#include <algorithm>
#include <cmath>

namespace loopline::line_slam {

LineGrid::Cell LineGrid::cell_of(const Eigen::Vector2d& p_m) {
    return {static_cast<int>(std::floor(p_m.x() / cell_m)), static_cast<int>(std::floor(p_m.y() / cell_m))};
}

void LineGrid::add(int id, const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m) {
    // At every half cell of the way, the cells around: no cell that the stretch crosses is missed.
    const int pieces = static_cast<int>(std::ceil((b_m - a_m).norm() / (0.5 * cell_m))) + 1;
    Cell before{0, 0};
    for (int k = 0; k <= pieces; ++k) {
        const Cell cell = cell_of(a_m + (b_m - a_m) * (static_cast<double>(k) / pieces));
        const auto put = [&](Cell c) {
            std::vector<int>& ids = cells_[c];
            if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
        };
        put(cell);
        if (k > 0 && cell.first != before.first && cell.second != before.second) {
            put({cell.first, before.second});
            put({before.first, cell.second});
        }
        before = cell;
    }
}

std::vector<int> LineGrid::in_box(const Eigen::Vector2d& least_m, const Eigen::Vector2d& greatest_m) const {
    const Cell from = cell_of(least_m), to = cell_of(greatest_m);
    std::vector<int> ids;
    for (int x = from.first; x <= to.first; ++x)
        for (auto c = cells_.lower_bound({x, from.second});
             c != cells_.end() && c->first <= Cell{x, to.second}; ++c)
            ids.insert(ids.end(), c->second.begin(), c->second.end());
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
}

}  // namespace loopline::line_slam
