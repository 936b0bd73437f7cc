#include "render/chart.h"

#include <algorithm>
#include <cmath>

#include "render/scale.h"

namespace loopline {
namespace {

/// Stretches of a curve without a break, as pixels; what is far outside of the window ends near it.
std::vector<Pixels> stretches_of(const ChartWindow& window, const Curve& curve) {
    std::vector<Pixels> stretches;
    bool pen_down = false;
    for (const Eigen::Vector2d& value : curve) {
        if (!value.allFinite()) {
            pen_down = false;
            continue;
        }
        if (!pen_down) stretches.emplace_back();
        pen_down = true;
        Eigen::Vector2d at = window.pixel(value);
        at.y() =
            std::clamp(at.y(), window.box.y - window.box.height, window.box.bottom() + window.box.height);
        stretches.back().push_back(at);
    }
    return stretches;
}

}  // namespace

ChartWindow chart_about(const std::vector<Curve>& curves, const Box& box, double least_height) {
    Eigen::Array2d low = Eigen::Array2d::Constant(INFINITY), high = -low;
    for (const Curve& curve : curves)
        for (const Eigen::Vector2d& value : curve)
            if (value.allFinite()) {
                low = low.min(value.array());
                high = high.max(value.array());
            }
    if (!(low.x() <= high.x())) return {box, {0, 0}, {1, 1}};
    const double margin = std::max(0.06 * (high.y() - low.y()), (least_height - high.y() + low.y()) / 2);
    low.y() -= margin;
    high.y() += margin;
    if (high.x() - low.x() < 1e-6) high.x() = low.x() + 1;
    return {box, low.matrix(), high.matrix()};
}

void draw_chart_axes(Figure& figure, const ChartWindow& window, const std::string& x_unit,
                     const std::string& y_unit) {
    Canvas& canvas = figure.canvas();
    const double size_px = 0.82 * figure.body_px();
    const Box& box = window.box;
    double step = 1;
    const auto across = ticks(window.low.x(), window.high.x(),
                              std::max(2, static_cast<int>(box.width / (6.5 * size_px))), step);
    for (const double x : across) {
        const double at = window.pixel({x, window.low.y()}).x();
        canvas.polyline({{at, box.y}, {at, box.bottom()}}, 0.5, palette::graticule);
        const std::string text = tick_text(x, step) + (x == across.front() ? x_unit : "");
        const double half = text_width_px(text, size_px) / 2;
        if (at + half <= box.right() + figure.body_px())
            canvas.text(text, std::max(at, box.x - figure.body_px() + half), box.bottom() + 1.25 * size_px,
                        size_px, palette::quiet_ink, Weight::regular, Align::centre);
    }
    const auto upward = ticks(window.low.y(), window.high.y(),
                              std::max(2, static_cast<int>(box.height / (2.2 * size_px))), step);
    for (const double y : upward) {
        const double at = window.pixel({window.low.x(), y}).y();
        canvas.polyline({{box.x, at}, {box.right(), at}}, 0.5, palette::graticule);
        if (at < box.y + 0.3 * size_px || at > box.bottom() - 0.2 * size_px) continue;
        const std::string text = tick_text(y, step) + (y == upward.back() ? y_unit : "");
        const double room_px = box.x - 0.8 * size_px,
                     fits_px = size_px * std::min(1.0, room_px / text_width_px(text, size_px));
        canvas.text(text, box.x - 0.4 * size_px, at + 0.36 * size_px, fits_px, palette::quiet_ink,
                    Weight::regular, Align::right);
    }
}

void draw_curve(Figure& figure, const ChartWindow& window, const Curve& curve, Colour colour, double width_px,
                bool dashed) {
    for (const Pixels& stretch : stretches_of(window, curve)) {
        if (dashed)
            figure.canvas().dashed_polyline(thinned(stretch, 0.5), width_px, 3.2 * width_px, colour);
        else
            figure.canvas().polyline(thinned(stretch, 0.5), width_px, colour);
    }
}

void draw_band(Figure& figure, const ChartWindow& window, const Curve& curve, Colour colour) {
    Curve below = curve;
    for (Eigen::Vector2d& value : below) value.y() = -value.y();
    const auto upper = stretches_of(window, curve), lower = stretches_of(window, below);
    for (std::size_t i = 0; i < upper.size(); ++i) {
        Pixels outline = upper[i];
        outline.insert(outline.end(), lower[i].rbegin(), lower[i].rend());
        figure.canvas().polygon(outline, colour);
    }
}

}  // namespace loopline
