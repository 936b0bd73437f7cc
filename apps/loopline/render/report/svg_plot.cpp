/// Data to SVG user units; the page scales the whole drawing.
#include "render/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/report/html.h"
#include "render/scale.h"

namespace loopline {
namespace {

struct AxisRange {
    double low = INFINITY, high = -INFINITY;
    void add(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    double span() const { return high - low; }
    void widen_to(double span_wanted) {
        const double more = std::max(0.0, span_wanted - span()) / 2;
        low -= more;
        high += more;
    }
};

std::string unit(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f", value);
    for (char& c : text)
        if (c == ',') c = '.';
    return text;
}

struct Axes {
    AxisRange x, y;
    double left = 52, right = 468, top = 26, bottom = 214;

    double px(double value) const { return left + (value - x.low) / x.span() * (right - left); }
    double py(double value) const { return bottom - (value - y.low) / y.span() * (bottom - top); }
};

std::string path_data(const Axes& axes, const PlotSeries& series) {
    std::string data;
    bool pen_down = false;
    std::string last;
    for (const auto& p : series.points) {
        if (!p.allFinite()) {
            pen_down = false;
            continue;
        }
        const std::string at = unit(axes.px(p.x())) + " " + unit(axes.py(p.y()));
        if (pen_down && at == last) continue;
        data += (pen_down ? "L" : "M") + at;
        last = at;
        pen_down = true;
    }
    return series.is_area && !data.empty() ? data + "Z" : data;
}

std::string text_at(double x, double y, const char* anchor, const std::string& text, const char* css_class) {
    return "<text x=\"" + unit(x) + "\" y=\"" + unit(y) + "\" text-anchor=\"" + anchor + "\" class=\"" +
           css_class + "\">" + html::escaped(text) + "</text>";
}

std::string line(double x0, double y0, double x1, double y1, const char* css_class) {
    return "<path class=\"" + std::string(css_class) + "\" d=\"M" + unit(x0) + " " + unit(y0) + "L" +
           unit(x1) + " " + unit(y1) + "\"/>";
}

std::string axes_svg(const Axes& axes, const Plot& plot) {
    std::string svg;
    double step = 1;
    for (const double x : ticks(axes.x.low, axes.x.high, 7, step)) {
        svg += line(axes.px(x), axes.top, axes.px(x), axes.bottom, "grid");
        svg += text_at(axes.px(x), axes.bottom + 16, "middle", tick_text(x, step), "tick");
    }
    for (const double y : ticks(axes.y.low, axes.y.high, 7, step)) {
        svg += line(axes.left, axes.py(y), axes.right, axes.py(y), "grid");
        svg += text_at(axes.left - 6, axes.py(y) + 4, "end", tick_text(y, step), "tick");
    }
    svg += line(axes.left, axes.bottom, axes.right, axes.bottom, "axis") +
           line(axes.left, axes.top, axes.left, axes.bottom, "axis");
    svg += text_at(axes.right, axes.bottom + 32, "end", plot.x_label, "label");
    svg += text_at(4, 13, "start", plot.y_label, "label");
    return svg;
}

}  // namespace

std::string svg_plot(const Plot& plot) {
    Axes axes;
    axes.right = plot.width - 12;
    axes.bottom = plot.height - 36;
    for (const auto* list : {&plot.series, &plot.marks})
        for (const auto& series : *list)
            for (const auto& p : series.points)
                if (p.allFinite()) {
                    axes.x.add(p.x());
                    axes.y.add(p.y());
                }
    if (!(axes.x.low <= axes.x.high)) return {};
    const double largest =
        std::max({std::abs(axes.x.low), std::abs(axes.x.high), std::abs(axes.y.low), std::abs(axes.y.high)});
    axes.x.widen_to(std::max(1e-6, 1e-9 * largest));
    axes.y.widen_to(std::max(1e-6, 1e-9 * largest));
    if (plot.equal_scale) {
        axes.x.widen_to(1.06 * axes.x.span());
        axes.y.widen_to(1.06 * axes.y.span());
        const double aspect = (axes.right - axes.left) / (axes.bottom - axes.top);
        axes.x.widen_to(axes.y.span() * aspect);
        axes.y.widen_to(axes.x.span() / aspect);
    } else {
        axes.y.widen_to(1.06 * axes.y.span());
    }
    std::string svg = "<svg viewBox=\"0 0 " + std::to_string(plot.width) + " " + std::to_string(plot.height) +
                      "\" role=\"img\" aria-label=\"" + html::escaped(plot.title) + "\">" +
                      axes_svg(axes, plot);
    for (const auto& series : plot.series)
        svg += "<path class=\"" + series.css_class + "\" d=\"" + path_data(axes, series) + "\"/>";
    for (const auto& marks : plot.marks)
        for (const auto& p : marks.points)
            if (p.allFinite())
                svg += "<circle class=\"" + marks.css_class + "\" cx=\"" + unit(axes.px(p.x())) + "\" cy=\"" +
                       unit(axes.py(p.y())) + "\" r=\"5\"/>";
    return svg + "</svg>";
}

std::vector<Eigen::Vector2d> thinned_signal(const std::vector<Eigen::Vector2d>& points, std::size_t most) {
    if (points.size() <= most || most < 4) return points;
    std::vector<Eigen::Vector2d> kept;
    const std::size_t buckets = most / 2;
    for (std::size_t b = 0; b < buckets; ++b) {
        const std::size_t first = points.size() * b / buckets, last = points.size() * (b + 1) / buckets;
        std::size_t lowest = first, highest = first;
        for (std::size_t i = first; i < last; ++i) {
            if (points[i].y() < points[lowest].y()) lowest = i;
            if (points[i].y() > points[highest].y()) highest = i;
        }
        kept.push_back(points[std::min(lowest, highest)]);
        if (lowest != highest) kept.push_back(points[std::max(lowest, highest)]);
    }
    return kept;
}

}  // namespace loopline
