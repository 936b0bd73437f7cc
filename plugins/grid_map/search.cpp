#include "grid_map/search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "grid_map/search_area.h"

namespace loopline::grid_map {
namespace {

/// What the distance from the window's centre costs, in the units of the likelihood: -log of the prior's
/// density. A return counts for a tenth of its likelihood, since returns next to each other err together.
class PriorCost {
 public:
    PriorCost(const ScanGrid& grid, const SearchWindow& window) {
        constexpr double weight = ScanGrid::full_likelihood * 10;
        const auto costs = [](int to_each_side, double step, double sigma) {
            std::vector<int> c;
            for (int k = -to_each_side; k <= to_each_side; ++k)
                c.push_back(static_cast<int>(
                    std::lround(std::min(1e8, 0.5 * weight * std::pow(k * step / sigma, 2)))));
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

/// The cells of the points at the centre of the window, heading by heading.
std::vector<std::vector<CellIndex>> turn(const ScanGrid& grid,
                                         const std::vector<Eigen::Vector2f>& points_base_m,
                                         const SearchWindow& window) {
    std::vector<std::vector<CellIndex>> all;
    all.reserve(static_cast<std::size_t>(2 * window.headings + 1));
    for (int k = -window.headings; k <= window.headings; ++k) {
        const double phi = window.T_map_center.phi_rad + k * window.heading_step_rad;
        const double c = std::cos(phi) / grid.cell_m(), s = std::sin(phi) / grid.cell_m(),
                     x = window.T_map_center.x_m / grid.cell_m(), y = window.T_map_center.y_m / grid.cell_m();
        std::vector<CellIndex> cells(points_base_m.size());
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const double px = points_base_m[i].x(), py = points_base_m[i].y();
            cells[i] = {ScanGrid::floor_to_int(x + c * px - s * py),
                        ScanGrid::floor_to_int(y + s * px + c * py)};
        }
        all.push_back(std::move(cells));
    }
    return all;
}

SearchResult result_at(const ScanGrid& grid, const SearchWindow& window, int heading, int dx, int dy,
                       int score, int likelihood, std::size_t points) {
    SearchResult result;
    result.T_map_base = {window.T_map_center.x_m + dx * grid.cell_m(),
                         window.T_map_center.y_m + dy * grid.cell_m(),
                         wrap_to_pi(window.T_map_center.phi_rad + heading * window.heading_step_rad)};
    result.dx_cells = dx;
    result.dy_cells = dy;
    result.heading = heading;
    result.score = score;
    result.fit = points > 0 ? static_cast<double>(likelihood) /
                                  (ScanGrid::full_likelihood * static_cast<double>(points))
                            : 0;
    return result;
}

constexpr int lanes = SearchArea::block;  ///< places beside each other
using Bytes = std::uint8_t __attribute__((vector_size(lanes)));
using Words = std::uint16_t __attribute__((vector_size(2 * lanes)));

/// What some points in a layer of a SearchArea say about `lanes` places beside each other. False, and the
/// sums are not whole, as soon as none of the places can come to `enough`.
bool sum_lanes(const std::uint8_t* layer, const std::vector<std::int32_t>& points, std::int32_t place,
               int enough, std::array<int, lanes>& sums) {
    constexpr std::size_t step = 16;  // their sum fits in a word
    sums.fill(0);
    for (std::size_t done = 0; done < points.size();) {
        const std::size_t until = std::min(points.size(), done + step);
        Words part{};
        for (; done < until; ++done) {
            Bytes row;
            std::memcpy(&row, layer + points[done] + place, sizeof row);
            part += __builtin_convertvector(row, Words);
        }
        int best = 0;
        for (int k = 0; k < lanes; ++k) best = std::max(best, sums[static_cast<std::size_t>(k)] += part[k]);
        if (best + ScanGrid::full_likelihood * static_cast<int>(points.size() - done) < enough) return false;
    }
    return true;
}

/// The same number of points from all parts of the scan first, so that a few of them tell of all.
std::vector<Eigen::Vector2f> spread(const std::vector<Eigen::Vector2f>& points) {
    constexpr std::size_t stride = 13;
    std::vector<Eigen::Vector2f> all;
    all.reserve(points.size());
    for (std::size_t first = 0; first < stride; ++first)
        for (std::size_t i = first; i < points.size(); i += stride) all.push_back(points[i]);
    return all;
}

/// Places of one heading, from (dx, dy) to the right and upward.
struct Node {
    int bound, heading, dx, dy;
};

/// Blocks of 16 x 16 places, of which the best is divided into 16 x 4, and these into single rows.
class BranchAndBound {
 public:
    BranchAndBound(const ScanGrid& grid, const SearchWindow& window,
                   const std::vector<std::vector<CellIndex>>& turned, const SearchArea& area)
        : grid_(grid), window_(window), prior_(grid, window), area_(area) {
        for (const auto& cells : turned) {
            auto& points = turned_.emplace_back();
            points.reserve(cells.size());
            for (const CellIndex& cell : cells) points.push_back(area.at(cell));
        }
    }

    std::optional<SearchResult> run() {
        std::vector<std::pair<int, int>> corners;
        for (int dy = -window_.cells_y; dy <= window_.cells_y; dy += SearchArea::block)
            for (int dx = -window_.cells_x; dx <= window_.cells_x; dx += lanes)
                if (any_allowed(dx, dy)) corners.emplace_back(dx, dy);
        std::vector<Node> blocks;
        for (int heading = -window_.headings; heading <= window_.headings; ++heading)
            for (const auto& [dx, dy] : corners)
                if (const Node node = block(heading, dx, dy); can_win(node)) blocks.push_back(node);
        std::sort(blocks.begin(), blocks.end(), [](const Node& a, const Node& b) {
            return a.bound != b.bound ? a.bound > b.bound : before(a, b);
        });
        for (const Node& node : blocks)
            if (can_win(node) && !excluded(node, SearchArea::block)) explore_block(node);
        if (!found_) return std::nullopt;
        return result_at(
            grid_, window_, best_.heading, best_.dx, best_.dy, best_.bound,
            best_.bound + prior_.heading(best_.heading) + prior_.x(best_.dx, 1) + prior_.y(best_.dy, 1),
            turned_.front().size());
    }

 private:
    const std::vector<std::int32_t>& points(int heading) const {
        return turned_[static_cast<std::size_t>(heading + window_.headings)];
    }
    std::int32_t place(int dx, int dy) const { return dx + dy * area_.stride(); }

    Node block(int heading, int dx, int dy) const {
        // The one block of a heading: the middle first, as what is searched for is likely near it.
        if (!area_.has_blocks())
            return {std::numeric_limits<int>::max() - std::abs(heading), heading, dx, dy};
        const std::uint8_t* best = area_.best_of_block() + place(dx, dy);
        int sum = 0;
        for (const std::int32_t point : points(heading)) sum += best[point];
        return {sum - prior_.heading(heading) - prior_.x(dx, lanes) - prior_.y(dy, SearchArea::block),
                heading, dx, dy};
    }

    void explore_block(const Node& node) {
        std::array<Node, SearchArea::block / SearchArea::rows> parts;
        std::size_t count = 0;
        for (int dy = node.dy; dy <= std::min(node.dy + SearchArea::block - 1, window_.cells_y);
             dy += SearchArea::rows) {
            Node part{0, node.heading, node.dx, dy};
            if (!bound_rows(part) || !can_win(part) || excluded(part, SearchArea::rows)) continue;
            std::size_t at = count++;
            for (; at > 0 && parts[at - 1].bound < part.bound; --at) parts[at] = parts[at - 1];
            parts[at] = part;
        }
        for (std::size_t k = 0; k < count; ++k)
            for (int r = 0; r < SearchArea::rows && parts[k].dy + r <= window_.cells_y; ++r)
                if (can_win(parts[k])) explore_row({parts[k].bound, node.heading, node.dx, parts[k].dy + r});
    }

    /// The bound of `rows` rows of places. False if none of them can win.
    bool bound_rows(Node& part) const {
        const int cost = prior_.heading(part.heading) + prior_.y(part.dy, SearchArea::rows);
        std::array<int, lanes> sums;
        if (!sum_lanes(area_.best_of_rows(), points(part.heading), place(part.dx, part.dy),
                       enough() + cost + prior_.x(part.dx, lanes), sums))
            return false;
        part.bound = std::numeric_limits<int>::min();
        for (int k = 0; k < lanes && part.dx + k <= window_.cells_x; ++k)
            part.bound =
                std::max(part.bound, sums[static_cast<std::size_t>(k)] - cost - prior_.x(part.dx + k, 1));
        return true;
    }

    void explore_row(const Node& row) {
        const int cost = prior_.heading(row.heading) + prior_.y(row.dy, 1);
        std::array<int, lanes> sums;
        if (!sum_lanes(area_.likelihood(), points(row.heading), place(row.dx, row.dy),
                       enough() + cost + prior_.x(row.dx, lanes), sums))
            return;
        for (int k = 0; k < lanes && row.dx + k <= window_.cells_x; ++k) {
            const Node one{sums[static_cast<std::size_t>(k)] - cost - prior_.x(row.dx + k, 1), row.heading,
                           row.dx + k, row.dy};
            if (!can_win(one) || window_.holds_back(one.heading, one.dx, one.dy)) continue;
            best_ = one;
            found_ = true;
        }
    }

    /// The order among places with equal scores; the first place of a node is that with the lowest dx and dy.
    static bool before(const Node& a, const Node& b) {
        if (a.heading != b.heading) return a.heading < b.heading;
        return a.dy != b.dy ? a.dy < b.dy : a.dx < b.dx;
    }
    bool can_win(const Node& node) const {
        if (node.bound < window_.min_score) return false;
        return !found_ || node.bound > best_.bound || (node.bound == best_.bound && before(node, best_));
    }
    int enough() const { return found_ ? std::max(best_.bound, window_.min_score) : window_.min_score; }
    /// Whether one exclusion holds all places of a node.
    bool excluded(const Node& node, int height) const {
        const auto by = [&](const SearchWindow::Exclusion& e) {
            return e.holds(node.heading, node.dx, node.dy) &&
                   e.holds(node.heading, std::min(node.dx + lanes - 1, window_.cells_x),
                           std::min(node.dy + height - 1, window_.cells_y));
        };
        return (window_.without && by(*window_.without)) ||
               std::any_of(window_.also_without.begin(), window_.also_without.end(), by);
    }
    /// In the block of positions from here on.
    bool any_allowed(int dx, int dy) const {
        if (window_.allowed.empty()) return true;
        const int width = 2 * window_.cells_x + 1, right = std::min(dx + lanes - 1, window_.cells_x);
        for (int y = dy; y <= std::min(dy + SearchArea::block - 1, window_.cells_y); ++y) {
            const auto* row = &window_.allowed[static_cast<std::size_t>((y + window_.cells_y) * width)];
            if (std::any_of(row + dx + window_.cells_x, row + right + window_.cells_x + 1,
                            [](std::uint8_t a) { return a != 0; }))
                return true;
        }
        return false;
    }

    const ScanGrid& grid_;
    const SearchWindow& window_;
    PriorCost prior_;
    const SearchArea& area_;
    std::vector<std::vector<std::int32_t>> turned_;
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
        way_m[i] = way_m[i - 1] +
                   std::min(longest_step_m, (frame.points[i].p_base_m - frame.points[i - 1].p_base_m).norm());
    const float step_m = way_m.back() / static_cast<float>(count);
    float next_m = 0;
    for (std::size_t i = 0; i < frame.points.size(); ++i) {
        if (way_m[i] < next_m) continue;
        chosen.push_back(frame.points[i].p_base_m);
        next_m = way_m[i] + step_m;
    }
    return chosen;
}

std::optional<SearchResult> branch_and_bound(const ScanGrid& grid,
                                             const std::vector<Eigen::Vector2f>& points_base_m,
                                             const SearchWindow& window) {
    const auto turned = turn(grid, spread(points_base_m), window);
    const SearchArea* area = SearchArea::around(grid, turned, window.cells_x, window.cells_y);
    if (area == nullptr) return exhaustive_search(grid, points_base_m, window);
    return BranchAndBound(grid, window, turned, *area).run();
}

std::optional<SearchResult> exhaustive_search(const ScanGrid& grid,
                                              const std::vector<Eigen::Vector2f>& points_base_m,
                                              const SearchWindow& window) {
    const PriorCost prior(grid, window);
    std::optional<SearchResult> best;
    int heading = -window.headings - 1;
    for (const auto& cells : turn(grid, points_base_m, window)) {
        ++heading;
        for (int dy = -window.cells_y; dy <= window.cells_y; ++dy)
            for (int dx = -window.cells_x; dx <= window.cells_x; ++dx) {
                if (window.holds_back(heading, dx, dy)) continue;
                int sum = 0;
                for (const CellIndex& cell : cells) sum += grid.likelihood(0, cell.x + dx, cell.y + dy);
                const int score = sum - prior.heading(heading) - prior.x(dx, 1) - prior.y(dy, 1);
                if (score < window.min_score || (best && score <= best->score)) continue;
                best = result_at(grid, window, heading, dx, dy, score, sum, points_base_m.size());
            }
    }
    return best;
}

}  // namespace loopline::grid_map
