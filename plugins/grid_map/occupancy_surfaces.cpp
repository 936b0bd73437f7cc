#include "grid_map/occupancy_surfaces.h"

#include <algorithm>
#include <cmath>

namespace loopline::grid_map {
namespace {

constexpr int fit_reach = 4;    ///< cells to each side that a surface is fitted through
constexpr int least_reach = 2;  ///< the same where it ends or turns within them
constexpr int window_side = 2 * fit_reach + 1;

/// The cells around one of them, by which side of the occupied ones they are on.
class Surroundings {
 public:
    Surroundings(const CoarseOccupancy& map, int x, int y) : map_(map), x_(x), y_(y) {
        for (auto& row : part_)
            for (int& part : row) part = none;
    }

    /// The free cells that touch the middle, as parts that no way within the window joins. Free cells join
    /// along their edges only, so that a wall on the diagonal has two sides.
    int divide() {
        int parts = 0;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                if (is_free(dx, dy) && part(dx, dy) == none) flood(dx, dy, parts++);
        return parts;
    }
    int part_at(int dx, int dy) const {
        return std::abs(dx) > fit_reach || std::abs(dy) > fit_reach ? none
                                                                    : part_[dy + fit_reach][dx + fit_reach];
    }

    /// Occupied cells that border on a free part, as far as they hang together with the middle.
    std::vector<Eigen::Vector2d> front(int of_part, int within) const {
        bool seen[window_side][window_side] = {};
        std::vector<std::pair<int, int>> open{{0, 0}};
        seen[fit_reach][fit_reach] = true;
        std::vector<Eigen::Vector2d> points_m;
        while (!open.empty()) {
            const auto [cx, cy] = open.back();
            open.pop_back();
            points_m.push_back(map_.means_m[map_.index(x_ + cx, y_ + cy)]);
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const int nx = cx + dx, ny = cy + dy;
                    if (std::abs(nx) > within || std::abs(ny) > within ||
                        seen[ny + fit_reach][nx + fit_reach])
                        continue;
                    seen[ny + fit_reach][nx + fit_reach] = true;
                    if (map_.at(x_ + nx, y_ + ny) == MapCell::occupied && borders(nx, ny, of_part))
                        open.emplace_back(nx, ny);
                }
        }
        return points_m;
    }

 private:
    static constexpr int none = -1;
    bool is_free(int dx, int dy) const { return map_.at(x_ + dx, y_ + dy) == MapCell::free; }
    int& part(int dx, int dy) { return part_[dy + fit_reach][dx + fit_reach]; }
    bool borders(int cx, int cy, int of_part) const {
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                if (part_at(cx + dx, cy + dy) == of_part) return true;
        return false;
    }
    void flood(int dx, int dy, int number) {
        std::vector<std::pair<int, int>> open{{dx, dy}};
        part(dx, dy) = number;
        while (!open.empty()) {
            const auto [cx, cy] = open.back();
            open.pop_back();
            for (const auto& [sx, sy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
                const int nx = cx + sx, ny = cy + sy;
                if (std::abs(nx) > fit_reach || std::abs(ny) > fit_reach || !is_free(nx, ny) ||
                    part(nx, ny) != none)
                    continue;
                part(nx, ny) = number;
                open.emplace_back(nx, ny);
            }
        }
    }

    const CoarseOccupancy& map_;
    int x_, y_;
    int part_[window_side][window_side];
};

struct CellLine {
    bool good = false;
    Eigen::Vector2d mean_m = Eigen::Vector2d::Zero(), normal = Eigen::Vector2d::Zero();
};

/// By least squares; bad if the points scatter about it by more than cells do, or are as wide as they are
/// long.
CellLine line_through(const std::vector<Eigen::Vector2d>& points_m, double cell_m) {
    CellLine line;
    if (points_m.size() < 3) return line;
    const auto n = static_cast<double>(points_m.size());
    line.mean_m.setZero();
    for (const auto& p : points_m) line.mean_m += p / n;
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const auto& p : points_m) spread += (p - line.mean_m) * (p - line.mean_m).transpose() / n;
    const double mean = spread.trace() / 2,
                 half = std::hypot((spread(0, 0) - spread(1, 1)) / 2, spread(0, 1)), across = mean - half,
                 along = mean + half;
    const double along_rad = 0.5 * std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1));
    line.normal = {-std::sin(along_rad), std::cos(along_rad)};
    line.good = across <= 0.5 * cell_m * cell_m && across <= 0.15 * along;
    return line;
}

bool is_near_free(const CoarseOccupancy& map, int x, int y, int cells) {
    for (int dy = -cells; dy <= cells; ++dy)
        for (int dx = -cells; dx <= cells; ++dx)
            if (map.at(x + dx, y + dy) == MapCell::free) return true;
    return false;
}

/// The points of one occupied cell.
void add_cell(const CoarseOccupancy& map, int x, int y, std::vector<SurfacePoint>& points) {
    const Eigen::Vector2d at_m = map.means_m[map.index(x, y)];
    const std::size_t before = points.size();
    Surroundings around(map, x, y);
    const int parts = around.divide();
    for (int part = 0; part < parts; ++part) {
        CellLine line;
        for (int within = fit_reach; within >= least_reach && !line.good; --within)
            line = line_through(around.front(part, within), map.cell_m);
        if (!line.good) continue;
        const Eigen::Vector2d p_m = at_m + line.normal.dot(line.mean_m - at_m) * line.normal;
        for (const double sign : {1.0, -1.0})
            for (const double steps : {1.0, 1.5, 2.0}) {
                const Eigen::Vector2d beside = sign * steps * line.normal;
                if (around.part_at(static_cast<int>(std::lround(beside.x())),
                                   static_cast<int>(std::lround(beside.y()))) != part)
                    continue;
                points.push_back({p_m.cast<float>(), (sign * line.normal).cast<float>()});
                break;
            }
    }
    if (points.size() == before) points.push_back({at_m.cast<float>(), Eigen::Vector2f::Zero()});
}

}  // namespace

CoarseOccupancy coarse_occupancy(const MapServerMap& map, double cell_m) {
    const auto step = static_cast<std::size_t>(std::max(1.0, std::floor(cell_m / map.resolution_m + 1e-6)));
    CoarseOccupancy coarse;
    coarse.width = static_cast<int>((map.width + step - 1) / step);
    coarse.height = static_cast<int>((map.height + step - 1) / step);
    coarse.cell_m = map.resolution_m * static_cast<double>(step);
    const std::size_t cells = coarse.index(0, coarse.height);
    coarse.cells.assign(cells, MapCell::unknown);
    coarse.means_m.assign(cells, Eigen::Vector2d::Zero());
    std::vector<int> occupied(cells, 0);
    for (std::size_t row = 0; row < map.height; ++row)
        for (std::size_t column = 0; column < map.width; ++column) {
            const MapCell cell = map.cells[map.index(column, row)];
            const std::size_t to =
                coarse.index(static_cast<int>(column / step), static_cast<int>(row / step));
            if (cell == MapCell::occupied) {
                coarse.cells[to] = cell;
                ++occupied[to];
                coarse.means_m[to] += map.resolution_m * Eigen::Vector2d(static_cast<double>(column) + 0.5,
                                                                         static_cast<double>(row) + 0.5);
            } else if (cell == MapCell::free && coarse.cells[to] == MapCell::unknown) {
                coarse.cells[to] = cell;
            }
        }
    for (std::size_t k = 0; k < cells; ++k)
        if (occupied[k] > 0) coarse.means_m[k] /= occupied[k];
    return coarse;
}

Frame surfaces_of(const CoarseOccupancy& map) {
    Frame frame;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            // What lies deeper in a wall than returns scatter is never seen.
            if (map.at(x, y) == MapCell::occupied && is_near_free(map, x, y, 2))
                add_cell(map, x, y, frame.points);
    return frame;
}

}  // namespace loopline::grid_map
