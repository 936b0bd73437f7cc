/// Curves in a panel of a picture.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "render/figure.h"

namespace loopline {

/// Values in x and y; one that is not finite breaks a line.
using Curve = std::vector<Eigen::Vector2d>;

/// A part of the plane of values in a part of the picture: x right, y up, each with its own scale.
struct ChartWindow {
    Box box;
    Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Ones();

    Eigen::Vector2d pixel(const Eigen::Vector2d& value) const {
        const Eigen::Array2d part = (value - low).array() / (high - low).array();
        return {box.x + part.x() * box.width, box.bottom() - part.y() * box.height};
    }
};

/// The window on all values of the curves, with a margin above and below; `least_height` high at least.
ChartWindow chart_about(const std::vector<Curve>& curves, const Box& box, double least_height);

/// Lines at round values with their numbers, the first of x and the last of y with their unit (" m").
void draw_chart_axes(Figure& figure, const ChartWindow& window, const std::string& x_unit,
                     const std::string& y_unit);
void draw_curve(Figure& figure, const ChartWindow& window, const Curve& curve, Colour colour, double width_px,
                bool dashed = false);
/// What lies between -y and y of the curve.
void draw_band(Figure& figure, const ChartWindow& window, const Curve& curve, Colour colour);

}  // namespace loopline
