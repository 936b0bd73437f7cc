#include "simulation/ray_caster.h"

#include <algorithm>
#include <cmath>

namespace loopline::simulation {
namespace {

constexpr double end_tolerance = 1e-9;  ///< of a wall's length, so that no ray slips through a corner
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Whether the segment from (x0, y0) by (dx, dy) touches the square of half width h around (cx, cy).
bool touches(double x0, double y0, double dx, double dy, double cx, double cy, double h) {
    const double mx = x0 + dx / 2 - cx, my = y0 + dy / 2 - cy, ax = std::abs(dx) / 2, ay = std::abs(dy) / 2;
    if (std::abs(mx) > h + ax || std::abs(my) > h + ay) return false;
    // The axis that is normal to the segment.
    return std::abs(mx * dy - my * dx) <= h * (std::abs(dx) + std::abs(dy));
}

}  // namespace

/// The ray, and its projection on the plan: unit speed along the ray, `level` along the plan.
struct RayCaster::Ray {
    Ray(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction)
        : x(origin_m.x()),
          y(origin_m.y()),
          z(origin_m.z()),
          dx(direction.x()),
          dy(direction.y()),
          dz(direction.z()) {}
    double x, y, z, dx, dy, dz;
};

RayCaster::RayCaster(const World& world) : ground_m_(world.ground_m), ceiling_m_(world.ceiling_m) {
    for (const Wall& wall : world.walls)
        edges_.push_back({wall.from_m.x(), wall.from_m.y(), wall.to_m.x() - wall.from_m.x(),
                          wall.to_m.y() - wall.from_m.y(), wall.bottom_m, wall.top_m});
    build_grid();
}

void RayCaster::build_grid() {
    if (edges_.empty()) return;
    double x_min = infinity, y_min = infinity, x_max = -infinity, y_max = -infinity;
    for (const Edge& e : edges_) {
        x_min = std::min({x_min, e.x_m, e.x_m + e.dx_m});
        x_max = std::max({x_max, e.x_m, e.x_m + e.dx_m});
        y_min = std::min({y_min, e.y_m, e.y_m + e.dy_m});
        y_max = std::max({y_max, e.y_m, e.y_m + e.dy_m});
    }
    const double area_m2 = std::max(x_max - x_min, 1.0) * std::max(y_max - y_min, 1.0);
    cell_m_ = std::clamp(std::sqrt(area_m2 / (4.0 * static_cast<double>(edges_.size()))), 0.25, 10.0);
    cells_per_m_ = 1 / cell_m_;
    origin_x_m_ = x_min - cell_m_;
    origin_y_m_ = y_min - cell_m_;
    columns_ = static_cast<int>((x_max - x_min) / cell_m_) + 3;
    rows_ = static_cast<int>((y_max - y_min) / cell_m_) + 3;

    std::vector<std::vector<std::int32_t>> cells(static_cast<std::size_t>(columns_) *
                                                 static_cast<std::size_t>(rows_));
    const double half_m = cell_m_ * (0.5 + 1e-6);
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        const Edge& e = edges_[i];
        const auto [left, right] = std::minmax({cell_x(e.x_m), cell_x(e.x_m + e.dx_m)});
        const auto [low, high] = std::minmax({cell_y(e.y_m), cell_y(e.y_m + e.dy_m)});
        for (int row = std::max(low - 1, 0); row <= std::min(high + 1, rows_ - 1); ++row)
            for (int column = std::max(left - 1, 0); column <= std::min(right + 1, columns_ - 1); ++column)
                if (touches(e.x_m, e.y_m, e.dx_m, e.dy_m, origin_x_m_ + (column + 0.5) * cell_m_,
                            origin_y_m_ + (row + 0.5) * cell_m_, half_m))
                    cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                          static_cast<std::size_t>(column)]
                        .push_back(static_cast<std::int32_t>(i));
    }
    for (const auto& cell : cells) {
        first_of_cell_.push_back(static_cast<std::uint32_t>(edges_of_cells_.size()));
        edges_of_cells_.insert(edges_of_cells_.end(), cell.begin(), cell.end());
    }
    first_of_cell_.push_back(static_cast<std::uint32_t>(edges_of_cells_.size()));
}

Hit RayCaster::cast_at_levels(const Ray& ray, double max_range_m) const {
    Hit hit;
    hit.range_m = max_range_m;
    const auto meet = [&](double level_m, int surface) {
        const double range_m = (level_m - ray.z) / ray.dz;
        if (range_m > 0 && range_m < hit.range_m) hit = {range_m, surface};
    };
    if (ray.dz < 0) meet(ground_m_, Hit::ground);
    if (ray.dz > 0 && std::isfinite(ceiling_m_)) meet(ceiling_m_, Hit::ceiling);
    return hit;
}

void RayCaster::meet_edge(const Ray& ray, int index, Hit& hit) const {
    const Edge& e = edges_[static_cast<std::size_t>(index)];
    const double across = ray.dx * e.dy_m - ray.dy * e.dx_m;
    if (across == 0) return;
    const double to_x = e.x_m - ray.x, to_y = e.y_m - ray.y;
    const double range_m = (to_x * e.dy_m - to_y * e.dx_m) / across;
    if (range_m <= 0 || range_m >= hit.range_m) return;
    const double part = (to_x * ray.dy - to_y * ray.dx) / across;
    if (part < -end_tolerance || part > 1 + end_tolerance) return;
    const double z_m = ray.z + ray.dz * range_m;
    if (z_m >= e.bottom_m && z_m <= e.top_m) hit = {range_m, index};
}

void RayCaster::meet_cylinder(const Ray& ray, const Cylinder& cylinder, Hit& hit) const {
    const double cx = cylinder.centre_m.x() - ray.x, cy = cylinder.centre_m.y() - ray.y;
    const double a = ray.dx * ray.dx + ray.dy * ray.dy;
    const double along = ray.dx * cx + ray.dy * cy;  // a t^2 - 2 along t + c = 0
    const double c = cx * cx + cy * cy - cylinder.radius_m * cylinder.radius_m;
    const double root = along * along - a * c;
    if (a == 0 || root < 0) return;
    const double range_m = (along - std::sqrt(root)) / a;
    if (range_m > 0 && range_m < hit.range_m && ray.z + ray.dz * range_m <= cylinder.top_m)
        hit = {range_m, Hit::cylinder};
}

void RayCaster::walk_grid(const Ray& ray, Hit& hit) const {
    // Where the ray is inside the grid's rectangle.
    double enter = 0, leave = hit.range_m;
    const auto clip = [&](double from, double speed, double low, double high) {
        if (speed == 0) {
            if (from < low || from > high) leave = -1;
            return;
        }
        const auto [first, last] = std::minmax({(low - from) / speed, (high - from) / speed});
        enter = std::max(enter, first);
        leave = std::min(leave, last);
    };
    clip(ray.x, ray.dx, origin_x_m_, origin_x_m_ + columns_ * cell_m_);
    clip(ray.y, ray.dy, origin_y_m_, origin_y_m_ + rows_ * cell_m_);
    if (enter > leave) return;

    int column = std::clamp(cell_x(ray.x + enter * ray.dx), 0, columns_ - 1);
    int row = std::clamp(cell_y(ray.y + enter * ray.dy), 0, rows_ - 1);
    const int step_x = ray.dx > 0 ? 1 : -1, step_y = ray.dy > 0 ? 1 : -1;
    const double per_column = ray.dx == 0 ? infinity : cell_m_ / std::abs(ray.dx);
    const double per_row = ray.dy == 0 ? infinity : cell_m_ / std::abs(ray.dy);
    double next_x =
        ray.dx == 0 ? infinity : (origin_x_m_ + (column + (step_x > 0)) * cell_m_ - ray.x) / ray.dx;
    double next_y = ray.dy == 0 ? infinity : (origin_y_m_ + (row + (step_y > 0)) * cell_m_ - ray.y) / ray.dy;
    while (true) {
        const std::size_t cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                                 static_cast<std::size_t>(column);
        for (std::uint32_t i = first_of_cell_[cell]; i < first_of_cell_[cell + 1]; ++i)
            meet_edge(ray, edges_of_cells_[i], hit);
        // A hit in a cell that is still to come is not the nearest yet.
        if (hit.range_m <= std::min(next_x, next_y)) return;
        if (next_x < next_y) {
            column += step_x;
            next_x += per_column;
            if (column < 0 || column >= columns_) return;
        } else {
            row += step_y;
            next_y += per_row;
            if (row < 0 || row >= rows_) return;
        }
    }
}

Hit RayCaster::cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double max_range_m,
                    const std::vector<Cylinder>& cylinders) const {
    const Ray ray(origin_m, direction);
    Hit hit = cast_at_levels(ray, max_range_m);
    for (const Cylinder& cylinder : cylinders) meet_cylinder(ray, cylinder, hit);
    if (!edges_.empty() && (ray.dx != 0 || ray.dy != 0)) walk_grid(ray, hit);
    if (hit.surface == Hit::nothing) hit.range_m = infinity;
    return hit;
}

Hit RayCaster::cast_at_all_walls(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                                 double max_range_m) const {
    const Ray ray(origin_m, direction);
    Hit hit = cast_at_levels(ray, max_range_m);
    for (std::size_t i = 0; i < edges_.size(); ++i) meet_edge(ray, static_cast<int>(i), hit);
    if (hit.surface == Hit::nothing) hit.range_m = infinity;
    return hit;
}

}  // namespace loopline::simulation
