/// The map seen from above, drawn with OpenCV: at the cost of MRPT's renderer (0.11 s CPU against 0.10 s for
/// the Telecom Faculty's 71 569 points at 1280x960), half its memory and without OpenGL, it has dashes, light
/// borders and true density.
#pragma once

#include <mrpt/maps/COccupancyGridMap2D.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "api/line_map.h"
#include "api/pose3.h"
#include "render/figure.h"

namespace loopline {

/// The grid as a faint background: free cells lighter than occupied ones, unknown cells not at all.
void draw_grid(Canvas& canvas, const MapWindow& window, const mrpt::maps::COccupancyGridMap2D& grid);

/// How points are coloured: one colour, or by height between two limits.
struct PointStyle {
    Colour colour = palette::scan_point;
    bool by_height = false;
    double lowest_m = 0, highest_m = 1;
};

/// Few points, as of trees, are drawn larger than the returns of many scans.
inline double point_size_px(std::size_t points, double body_px) {
    constexpr double many = 20000, smallest = 0.075, largest = 0.35;  // of the height of the text
    const double size = smallest * std::sqrt(many / static_cast<double>(std::max<std::size_t>(points, 1)));
    return std::max(1.0, std::clamp(size, smallest, largest) * body_px);
}

/// Points as a density: every point counts, none of three million hides what is under it, and a single one is
/// still seen.
class PointDensity {
 public:
    PointDensity(Canvas& canvas, const MapWindow& window, bool by_height);

    void add(const Eigen::Vector3f& p_map);
    void draw(const PointStyle& style, double point_px);

 private:
    cv::Mat pixels_;
    cv::Mat1f count_, height_;
    double left_m_, top_m_, px_per_m_;  ///< of the drawn pixels
    double hits_ = 0, hit_pixels_ = 0;
};

void draw_points(Canvas& canvas, const MapWindow& window, const std::vector<Eigen::Vector3f>& points_m,
                 const PointStyle& style, double point_px);

void draw_walls(Canvas& canvas, const MapWindow& window, const LineMap& lines, double width_px);

/// A path with a light border, so that it stays apart from what it crosses.
void draw_path(Canvas& canvas, const MapWindow& window, const std::vector<Pose3>& path, Colour colour,
               double width_px, bool dashed);

}  // namespace loopline
