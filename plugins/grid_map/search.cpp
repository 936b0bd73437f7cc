#include "grid_map/search.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace loopline::grid_map {
namespace {

/// What the distance from the window's centre costs, in the units of the likelihood: -log of the prior's density. A
/// return counts for a tenth of its likelihood, since returns next to each other err together.
class PriorCost {
 public:
    PriorCost(const ScanGrid& grid, const SearchWindow& window) {
        constexpr double weight = ScanGrid::full_likelihood * 10;
        const auto costs = [](int to_each_side, double step, double sigma) {
            std::vector<int> c;
            for (int k = -to_each_side; k <= to_each_side; ++k)
                c.push_back(static_cast<int>(std::lround(std::min(1e8, 0.5 * weight * std::pow(k * step / sigma, 2)))));
            return c;
        };
        x_ = costs(window.cells_x, grid.cell_m(), window.sigma_x_m);
        y_ = costs(window.cells_y, grid.cell_m(), window.sigma_y_m);
        heading_ = costs(window.headings, window.heading_step_rad, window.sigma_phi_rad);
    }
    int heading(int k) const { return heading_[static_cast<std::size_t>(k + middle(heading_))]; }
    /// The least of `size` neighbours from the one given on.
    int x(int k, int size) const { return least(x_, k, size); }
    int y(int k, int size) const { return least(y_, k, size); }

 private:
    static int middle(const std::vector<int>& costs) { return static_cast<int>(costs.size() / 2); }
    static int least(const std::vector<int>& costs, int k, int size) {
        const int last = std::min(k + size - 1, middle(costs));
        const int nearest = k > 0 ? k : std::min(last, 0);
        return costs[static_cast<std::size_t>(nearest + middle(costs))];
    }
    std::vector<int> x_, y_, heading_;
};

struct TurnedPoints {
    int heading = 0;
    std::vector<CellIndex> cells;  ///< of the points, at the centre of the window
};

std::vector<TurnedPoints> turn(const ScanGrid& grid, const std::vector<Eigen::Vector2f>& points_base_m,
                               const SearchWindow& window) {
    std::vector<TurnedPoints> all;
    all.reserve(static_cast<std::size_t>(2 * window.headings + 1));
    for (int k = -window.headings; k <= window.headings; ++k) {
        const double phi = window.T_map_center.phi_rad + k * window.heading_step_rad;
        const double c = std::cos(phi) / grid.cell_m(), s = std::sin(phi) / grid.cell_m(),
                     x = window.T_map_center.x_m / grid.cell_m(), y = window.T_map_center.y_m / grid.cell_m();
        TurnedPoints turned;
        turned.heading = k;
        turned.cells.reserve(points_base_m.size());
        for (const auto& p : points_base_m)
            turned.cells.push_back({ScanGrid::floor_to_int(x + c * p.x() - s * p.y()),
                                    ScanGrid::floor_to_int(y + s * p.x() + c * p.y())});
        all.push_back(std::move(turned));
    }
    return all;
}

SearchResult result_at(const ScanGrid& grid, const SearchWindow& window, int heading, int dx, int dy, int score,
                       int likelihood, std::size_t points) {
    SearchResult result;
    result.T_map_base = {window.T_map_center.x_m + dx * grid.cell_m(), window.T_map_center.y_m + dy * grid.cell_m(),
                         wrap_to_pi(window.T_map_center.phi_rad + heading * window.heading_step_rad)};
    result.dx_cells = dx;
    result.dy_cells = dy;
    result.heading = heading;
    result.score = score;
    result.fit = points > 0 ? static_cast<double>(likelihood) / (ScanGrid::full_likelihood * static_cast<double>(points)) : 0;
    return result;
}

/// 2^level x 2^level places of one heading.
struct Node {
    int bound, level, heading, dx, dy;
};

class BranchAndBound {
 public:
    BranchAndBound(const ScanGrid& grid, const std::vector<Eigen::Vector2f>& points, const SearchWindow& window)
        : grid_(grid), window_(window), prior_(grid, window), turned_(turn(grid, points, window)), points_(points.size()) {}

    std::optional<SearchResult> run() {
        const int side = 2 * std::max(window_.cells_x, window_.cells_y) + 1;
        int level = 0;
        while (level + 1 < ScanGrid::levels && (2 << level) <= side) ++level;
        std::vector<Node> coarse;
        for (int heading = -window_.headings; heading <= window_.headings; ++heading)
            for (int dy = -window_.cells_y; dy <= window_.cells_y; dy += 1 << level)
                for (int dx = -window_.cells_x; dx <= window_.cells_x; dx += 1 << level)
                    add_node(coarse, level, heading, dx, dy);
        best_first(coarse);
        for (const Node& node : coarse) explore(node);
        if (!found_) return std::nullopt;
        return result_at(grid_, window_, best_.heading, best_.dx, best_.dy, best_.bound,
                         best_.bound + cost(best_.heading, best_.dx, best_.dy, 1), points_);
    }

 private:
    int cost(int heading, int dx, int dy, int size) const {
        return prior_.heading(heading) + prior_.x(dx, size) + prior_.y(dy, size);
    }

    void add_node(std::vector<Node>& nodes, int level, int heading, int dx, int dy) const {
        const auto& layer = grid_.likelihood_layer(level);
        int sum = 0;
        for (const CellIndex& cell : turned_[static_cast<std::size_t>(heading + window_.headings)].cells)
            sum += layer.value((cell.x + dx) >> level, (cell.y + dy) >> level);
        nodes.push_back({sum - cost(heading, dx, dy, 1 << level), level, heading, dx, dy});
    }

    /// The order among places with equal scores.
    static bool before(const Node& a, const Node& b) {
        if (a.heading != b.heading) return a.heading < b.heading;
        return a.dy != b.dy ? a.dy < b.dy : a.dx < b.dx;
    }
    static void best_first(std::vector<Node>& nodes) {
        std::sort(nodes.begin(), nodes.end(),
                  [](const Node& a, const Node& b) { return a.bound != b.bound ? a.bound > b.bound : before(a, b); });
    }
    bool can_win(const Node& node) const {
        if (node.bound < window_.min_score) return false;
        return !found_ || node.bound > best_.bound || (node.bound == best_.bound && before(node, best_));
    }

    void explore(const Node& node) {
        if (!can_win(node)) return;
        if (node.level == 0) {
            if (window_.without && window_.without->holds(node.heading, node.dx, node.dy)) return;
            best_ = node;
            found_ = true;
            return;
        }
        std::vector<Node> parts;
        const int half = 1 << (node.level - 1);
        for (int k = 0; k < 4; ++k) {
            const int dx = node.dx + (k & 1) * half, dy = node.dy + (k >> 1) * half;
            if (dx <= window_.cells_x && dy <= window_.cells_y) add_node(parts, node.level - 1, node.heading, dx, dy);
        }
        best_first(parts);
        for (const Node& part : parts) explore(part);
    }

    const ScanGrid& grid_;
    const SearchWindow& window_;
    PriorCost prior_;
    std::vector<TurnedPoints> turned_;
    std::size_t points_;
    Node best_{};
    bool found_ = false;
};

}  // namespace

std::vector<Eigen::Vector2f> search_points(const Frame& frame, std::size_t count) {
    std::vector<Eigen::Vector2f> chosen;
    if (frame.points.empty() || count == 0) return chosen;
    // Steps along the surfaces, no longer than what lies between two surfaces counts.
    constexpr float longest_step_m = 0.5F;
    std::vector<float> way_m(frame.points.size(), 0);
    for (std::size_t i = 1; i < frame.points.size(); ++i)
        way_m[i] = way_m[i - 1] + std::min(longest_step_m, (frame.points[i].p_base_m - frame.points[i - 1].p_base_m).norm());
    const float step_m = way_m.back() / static_cast<float>(count);
    float next_m = 0;
    for (std::size_t i = 0; i < frame.points.size(); ++i) {
        if (way_m[i] < next_m) continue;
        chosen.push_back(frame.points[i].p_base_m);
        next_m = way_m[i] + step_m;
    }
    return chosen;
}

std::optional<SearchResult> branch_and_bound(const ScanGrid& grid, const std::vector<Eigen::Vector2f>& points_base_m,
                                             const SearchWindow& window) {
    return BranchAndBound(grid, points_base_m, window).run();
}

std::optional<SearchResult> exhaustive_search(const ScanGrid& grid, const std::vector<Eigen::Vector2f>& points_base_m,
                                              const SearchWindow& window) {
    const PriorCost prior(grid, window);
    std::optional<SearchResult> best;
    for (const TurnedPoints& turned : turn(grid, points_base_m, window))
        for (int dy = -window.cells_y; dy <= window.cells_y; ++dy)
            for (int dx = -window.cells_x; dx <= window.cells_x; ++dx) {
                if (window.without && window.without->holds(turned.heading, dx, dy)) continue;
                int sum = 0;
                for (const CellIndex& cell : turned.cells) sum += grid.likelihood(0, cell.x + dx, cell.y + dy);
                const int score = sum - prior.heading(turned.heading) - prior.x(dx, 1) - prior.y(dy, 1);
                if (score < window.min_score || (best && score <= best->score)) continue;
                best = result_at(grid, window, turned.heading, dx, dy, score, sum, points_base_m.size());
            }
    return best;
}

}  // namespace loopline::grid_map
