/// The distance to what a ray meets first. Exact: closed formulas for every surface, and a grid over the plan
/// only to leave out walls that can't be met (Amanatides, Woo 1987, "A fast voxel traversal algorithm for ray
/// tracing").
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "simulation/world.h"

namespace loopline::simulation {

/// An upright cylinder: a person, a post.
struct Cylinder {
    Eigen::Vector2d centre_m;
    double radius_m = 0;
    double top_m = 0;
};

struct Hit {
    static constexpr int ground = -1, ceiling = -2, cylinder = -3, nothing = -4;
    double range_m = std::numeric_limits<double>::infinity();
    int surface = nothing;  ///< index of the wall, or one of the above
};

class RayCaster {
 public:
    explicit RayCaster(const World& world);

    /// What the ray from `origin_m` along the unit vector `direction` meets first within `max_range_m`;
    /// cylinders are looked at one by one.
    Hit cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction, double max_range_m,
             const std::vector<Cylinder>& cylinders = {}) const;
    /// The same without the grid: every wall is tried. For tests.
    Hit cast_at_all_walls(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                          double max_range_m) const;

 private:
    /// A wall as the intersection wants it.
    struct Edge {
        double x_m, y_m, dx_m, dy_m;
        double bottom_m, top_m;
    };
    struct Ray;

    void build_grid();
    Hit cast_at_levels(const Ray& ray, double max_range_m) const;
    void meet_edge(const Ray& ray, int index, Hit& hit) const;
    void meet_cylinder(const Ray& ray, const Cylinder& cylinder, Hit& hit) const;
    void walk_grid(const Ray& ray, Hit& hit) const;
    int cell_x(double x_m) const { return static_cast<int>((x_m - origin_x_m_) * cells_per_m_); }
    int cell_y(double y_m) const { return static_cast<int>((y_m - origin_y_m_) * cells_per_m_); }

    std::vector<Edge> edges_;
    double ground_m_, ceiling_m_;
    double origin_x_m_ = 0, origin_y_m_ = 0, cell_m_ = 1, cells_per_m_ = 1;
    int columns_ = 0, rows_ = 0;
    std::vector<std::uint32_t> first_of_cell_;  ///< into edges_of_cells_; one more than there are cells
    std::vector<std::int32_t> edges_of_cells_;
};

}  // namespace loopline::simulation
