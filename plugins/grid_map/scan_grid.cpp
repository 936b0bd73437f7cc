#include "grid_map/scan_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace loopline::grid_map {
namespace {

constexpr int fraction = 1024;
constexpr int kernel_radius = 3;
constexpr int kernel_side = 2 * kernel_radius + 1;

/// 255 exp(-d^2 / 2) for d in cells: what a return is worth that lies beside a cell with one.
const std::array<std::uint8_t, kernel_side * kernel_side>& kernel() {
    static const auto values = [] {
        std::array<std::uint8_t, kernel_side * kernel_side> k{};
        for (int y = -kernel_radius; y <= kernel_radius; ++y)
            for (int x = -kernel_radius; x <= kernel_radius; ++x)
                k[static_cast<std::size_t>((y + kernel_radius) * kernel_side + x + kernel_radius)] =
                    static_cast<std::uint8_t>(
                        std::lround(ScanGrid::full_likelihood * std::exp(-0.5 * (x * x + y * y))));
        return k;
    }();
    return values;
}

std::uint8_t kernel_at(int dx, int dy) {
    return kernel()[static_cast<std::size_t>((dy + kernel_radius) * kernel_side + dx + kernel_radius)];
}

}  // namespace

void ScanGrid::apply(const Frame& frame, const Pose2& T_map_base, int sign) {
    const double c = std::cos(T_map_base.phi_rad), s = std::sin(T_map_base.phi_rad);
    const Eigen::Vector2d origin_m = T_map_base * frame.p_base_sensor_m.cast<double>();
    for (const SurfacePoint& point : frame.points) {
        const double px = point.p_base_m.x(), py = point.p_base_m.y(), nx = point.normal_base.x(),
                     ny = point.normal_base.y();
        const Eigen::Vector2d p_map_m(T_map_base.x_m + c * px - s * py, T_map_base.y_m + s * px + c * py);
        const double u = p_map_m.x() / settings_.cell_m, v = p_map_m.y() / settings_.cell_m;
        const CellIndex cell{floor_to_int(u), floor_to_int(v)};
        Surface& surface = surfaces_.at(cell.x, cell.y);
        const auto whole = [](double part) { return floor_to_int(part * fraction + 0.5); };
        const bool was_empty = surface.returns == 0;
        surface.returns += sign;
        surface.sum_x += sign * whole(u - cell.x);
        surface.sum_y += sign * whole(v - cell.y);
        surface.sum_nx += sign * whole(c * nx - s * ny);
        surface.sum_ny += sign * whole(s * nx + c * ny);
        if (was_empty) raise_likelihood(cell);
        if (surface.returns == 0) mark_for_settling(cell);
        if (settings_.free_space) add_pass(origin_m, p_map_m, sign);
    }
}

/// The cells from the sensor to a return, without that of the return (Amanatides and Woo 1987).
void ScanGrid::add_pass(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, int sign) {
    const Eigen::Vector2d from = from_m / settings_.cell_m, to = to_m / settings_.cell_m, way = to - from;
    int x = floor_to_int(from.x()), y = floor_to_int(from.y());
    const int last_x = floor_to_int(to.x()), last_y = floor_to_int(to.y());
    const int step_x = way.x() > 0 ? 1 : -1, step_y = way.y() > 0 ? 1 : -1;
    const double per_x = 1 / std::max(std::abs(way.x()), 1e-12),
                 per_y = 1 / std::max(std::abs(way.y()), 1e-12);
    double at_x = (step_x > 0 ? x + 1 - from.x() : from.x() - x) * per_x,
           at_y = (step_y > 0 ? y + 1 - from.y() : from.y() - y) * per_y;
    for (int left = std::abs(last_x - x) + std::abs(last_y - y); left > 0; --left) {
        passes_.at(x, y) += sign;
        if (at_x < at_y) {
            x += step_x;
            at_x += per_x;
        } else {
            y += step_y;
            at_y += per_y;
        }
    }
}

void ScanGrid::raise_likelihood(CellIndex cell) {
    for (int dy = -kernel_radius; dy <= kernel_radius; ++dy) {
        const int y = cell.y + dy;
        likelihood_[0].write_row(cell.x - kernel_radius, y, kernel_side,
                                 [&](int x0, std::uint8_t* row, int count) {
                                     for (int k = 0; k < count; ++k) {
                                         const std::uint8_t value = kernel_at(x0 + k - cell.x, dy);
                                         if (value <= row[k]) continue;
                                         row[k] = value;
                                         raise_bounds(x0 + k, y, value);
                                     }
                                 });
    }
}

void ScanGrid::raise_bounds(int x, int y, std::uint8_t value) {
    for (int h = 1; h < levels; ++h) {
        bool raised = false;
        likelihood_[h].write_square(x >> h, y >> h, [&](std::uint8_t& bound) {
            raised = raised || bound < value;
            bound = std::max(bound, value);
        });
        if (!raised) break;  // then no coarser one is raised either
    }
}

void ScanGrid::mark_for_settling(CellIndex emptied) {
    constexpr int bits = SparseArray<std::uint8_t>::tile_bits;
    for (int ty = (emptied.y - kernel_radius) >> bits; ty <= (emptied.y + kernel_radius) >> bits; ++ty)
        for (int tx = (emptied.x - kernel_radius) >> bits; tx <= (emptied.x + kernel_radius) >> bits; ++tx)
            unsettled_.emplace(tx, ty);
}

void ScanGrid::settle() {
    for (const auto& [x, y] : unsettled_) settle_tile(x, y);
    // A coarser level looks at the cells of the next tiles too, so these must be done.
    for (int h = 1; h < levels; ++h)
        for (const auto& [x, y] : unsettled_) settle_bounds(h, x, y);
    unsettled_.clear();
}

/// Level 0 of a tile anew.
void ScanGrid::settle_tile(int tile_x, int tile_y) {
    // With room around it for what lies partly outside.
    constexpr int side = SparseArray<std::uint8_t>::tile_side, room = 2 * kernel_radius,
                  padded = side + 2 * room;
    const int x0 = tile_x * side, y0 = tile_y * side;
    std::array<std::uint8_t, padded * padded> values{};
    surfaces_.visit_window(
        x0 - kernel_radius, y0 - kernel_radius, x0 + side - 1 + kernel_radius, y0 + side - 1 + kernel_radius,
        [&](int x, int y, const Surface& surface) {
            if (surface.returns == 0) return;
            for (int dy = 0; dy < kernel_side; ++dy) {
                std::uint8_t* row = &values[static_cast<std::size_t>(
                    (y - y0 + room - kernel_radius + dy) * padded + x - x0 + room - kernel_radius)];
                const std::uint8_t* by = &kernel()[static_cast<std::size_t>(dy * kernel_side)];
                for (int dx = 0; dx < kernel_side; ++dx) row[dx] = std::max(row[dx], by[dx]);
            }
        });
    for (int y = 0; y < side; ++y)
        likelihood_[0].write_row(x0, y0 + y, side, [&](int, std::uint8_t* row, int count) {
            std::copy_n(&values[static_cast<std::size_t>((y + room) * padded + room)], count, row);
        });
}

/// Level h anew where it looks at cells of a tile of level 0.
void ScanGrid::settle_bounds(int h, int tile_x, int tile_y) {
    constexpr int side = SparseArray<std::uint8_t>::tile_side;
    // Level 1 looks at four cells to each side, a coarser one at two even blocks of the level below it.
    const int parts = h == 1 ? 4 : 2, stride = h == 1 ? 1 : 2;
    const int first_x = ((tile_x * side) >> h) - 1, first_y = ((tile_y * side) >> h) - 1,
              count = (side >> h) + 1, below = 2 * (count - 1) + stride * (parts - 1) + 1;
    std::array<std::uint8_t, (side + 4) * (side + 4)> fine{};
    likelihood_[h - 1].visit_window(
        2 * first_x, 2 * first_y, 2 * first_x + below - 1, 2 * first_y + below - 1,
        [&](int x, int y, std::uint8_t value) {
            fine[static_cast<std::size_t>((y - 2 * first_y) * below + x - 2 * first_x)] = value;
        });
    // The best along x first, then along y.
    std::array<std::uint8_t, (side + 4) * (side / 2 + 1)> along_x{};
    const auto widest = [&](const std::uint8_t* from, int step) {
        std::uint8_t best = 0;
        for (int k = 0; k < parts; ++k) best = std::max(best, from[k * stride * step]);
        return best;
    };
    for (int y = 0; y < below; ++y)
        for (int x = 0; x < count; ++x)
            along_x[static_cast<std::size_t>(y * count + x)] =
                widest(&fine[static_cast<std::size_t>(y * below + 2 * x)], 1);
    for (int y = 0; y < count; ++y)
        for (int x = 0; x < count; ++x) {
            const std::uint8_t best = widest(&along_x[static_cast<std::size_t>(2 * y * count + x)], count);
            if (best != likelihood_[h].value(first_x + x, first_y + y))
                likelihood_[h].at(first_x + x, first_y + y) = best;
        }
}

std::size_t ScanGrid::bytes() const {
    std::size_t total = surfaces_.bytes() + passes_.bytes();
    for (const auto& level : likelihood_) total += level.bytes();
    return total;
}

bool ScanGrid::operator==(const ScanGrid& other) const {
    bool same = surfaces_ == other.surfaces_ && passes_ == other.passes_;
    for (int h = 0; h < levels; ++h) same = same && likelihood_[h] == other.likelihood_[h];
    return same;
}

void ScanGrid::drop_empty_tiles() {
    surfaces_.drop_empty_tiles();
    passes_.drop_empty_tiles();
    for (auto& level : likelihood_) level.drop_empty_tiles();
}

}  // namespace loopline::grid_map
