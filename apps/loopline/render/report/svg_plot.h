/// Line plots as inline SVG, coloured by the page's style sheet.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace loopline {

struct PlotSeries {
    std::string css_class;                ///< "estimate", "odometry", "band": see report_style.h
    std::vector<Eigen::Vector2d> points;  ///< a point that is not finite breaks the line
    bool is_area = false;                 ///< the points are the outline of a filled area
};

struct Plot {
    std::string title;
    std::string x_label, y_label;  ///< with unit: "time, s"
    std::vector<PlotSeries> series;
    std::vector<PlotSeries> marks;  ///< a dot at every point
    bool equal_scale = false;       ///< a map: one scale for both axes
    int width = 480, height = 250;
};

/// The plot with axes, ticks and labels; empty if no series has a finite point.
std::string svg_plot(const Plot& plot);

/// At most about `most` points of (x, y) with x increasing: from every bucket of x its lowest and its highest
/// y, so that no peak is lost.
std::vector<Eigen::Vector2d> thinned_signal(const std::vector<Eigen::Vector2d>& points, std::size_t most);

}  // namespace loopline
