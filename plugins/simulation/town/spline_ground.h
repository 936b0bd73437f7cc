/// Ground under a path that was recorded: the smoothest that passes below it.
#pragma once

#include <vector>

#include "simulation/ground.h"

namespace loopline::simulation {

/// Heights are a bicubic B-spline over a square grid: two continuous derivatives.
class SplineGround : public Ground {
 public:
    /// Least squares through all points, which lie on the ground, with little curvature elsewhere; out to
    /// `reach_m` from them, and as at the border of that beyond.
    SplineGround(const std::vector<Eigen::Vector3d>& points_m, double reach_m);

    double height_m(const Eigen::Vector2d& place_m) const override;
    Eigen::Vector2d slope(const Eigen::Vector2d& place_m) const override;

 private:
    struct Spot {
        int column, row;          ///< the first of four control heights each way
        double u, v;              ///< 0 .. 1 within the cell
        bool beyond_x, beyond_y;  ///< the place itself is off the grid
    };
    Spot spot(const Eigen::Vector2d& place_m) const;
    int index(int column, int row) const { return row * columns_ + column; }

    Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
    int columns_ = 0, rows_ = 0;
    std::vector<double> control_m_;
};

}  // namespace loopline::simulation
