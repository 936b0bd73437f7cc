#include "render/earth_views.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "render/chart.h"
#include "render/cloud_splat.h"
#include "render/content_bounds.h"
#include "render/figure.h"
#include "render/plan.h"
#include "render/scale.h"

namespace loopline {
namespace {

constexpr Colour with_fixes = palette::estimate, without_fixes = palette::dead_reckoning,
                 truth = palette::ink, used = palette::start, refused = palette::end;
constexpr Colour band_colour{205, 224, 240};
constexpr double degrees_per_rad = 180 / M_PI;

std::string text_of(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string capital(std::string text) {
    if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    return text;
}

void add_lines_to_legend(const EarthContent& content, std::vector<LegendEntry>& legend) {
    legend.push_back({Mark::line, "Result", with_fixes});
    legend.push_back({Mark::dashed_line, capital(content.uncorrected_name), without_fixes});
    if (content.has_truth) legend.push_back({Mark::line, "Truth", truth});
}

Bounds bounds_of_paths(const EarthContent& content) {
    Bounds bounds;
    for (const EarthMoment& moment : content.moments)
        for (const auto& p_m : {moment.p_m, moment.p_uncorrected_m, moment.p_true_m}) bounds.add(p_m);
    return bounds;
}

/// One within the other, the truth the widest: paths that can't be told apart at this scale are all seen.
void draw_paths(Figure& figure, const MapWindow& window, const EarthContent& content) {
    const auto line_of = [&](Eigen::Vector3d EarthMoment::*place) {
        Pixels line;
        for (const EarthMoment& moment : content.moments)
            line.push_back(window.pixel((moment.*place).head<2>()));
        return thinned(line, 0.5);
    };
    Canvas& canvas = figure.canvas();
    const double u = figure.body_px();
    const Pixels result = line_of(&EarthMoment::p_m), other = line_of(&EarthMoment::p_uncorrected_m),
                 true_path = line_of(&EarthMoment::p_true_m);
    for (const Pixels* line : {&true_path, &other, &result}) canvas.polyline(*line, 0.62 * u, palette::paper);
    canvas.polyline(true_path, 0.46 * u, truth);
    canvas.dashed_polyline(other, 0.28 * u, 0.8 * u, without_fixes);
    canvas.polyline(result, 0.14 * u, with_fixes);
}

/// A lighter shade of what is drawn there, so that lines stand out.
void whiten(cv::Mat pixels) {
    constexpr double left = 0.38;
    pixels.convertTo(pixels, -1, left, 255 * (1 - left));
}

void draw_ground(Figure& figure, const MapWindow& window, const SceneContent& map, bool cloud_lies_below) {
    if (map.grid) draw_grid(figure.canvas(), window, *map.grid);
    if (map.cloud && cloud_lies_below) {
        cv::Mat pixels = figure.canvas().drawn_pixels(window.box);
        const auto px_per_m = static_cast<float>(window.px_per_m * Canvas::supersampling);
        ParallelView view;
        view.linear = Eigen::Vector3f(px_per_m, -px_per_m, 1).asDiagonal();
        view.offset = {-px_per_m * static_cast<float>(window.left_m()),
                       px_per_m * static_cast<float>(window.top_m()), 0};
        splat_cloud(pixels, *map.cloud, view, height_colours(*map.cloud), 3);
    } else {
        draw_points(figure.canvas(), window, map.points_m, {},
                    point_size_px(map.points_m.size(), figure.body_px()));
    }
    whiten(figure.canvas().drawn_pixels(window.box));
}

/// Dots that don't cover each other where there are many.
void draw_fixes(Figure& figure, const MapWindow& window, const std::vector<Eigen::Vector2d>& places_m,
                Colour colour) {
    const double radius_px = 0.17 * figure.body_px();
    Pixels dots;
    for (const Eigen::Vector2d& p_m : places_m) dots.push_back(window.pixel(p_m));
    for (const Eigen::Vector2d& dot : thinned(dots, 6 * radius_px)) {
        const Box& box = window.box;
        if (dot.x() < box.x || dot.x() > box.right() || dot.y() < box.y || dot.y() > box.bottom()) continue;
        figure.canvas().disc(dot, 1.35 * radius_px, palette::paper);
        figure.canvas().disc(dot, radius_px, colour);
    }
}

/// How far the two lie apart at the end.
std::string subtitle_of(const EarthContent& content) {
    std::string text = "way " + text_of("%.0f m", content.moments.back().way_m);
    if (!content.fixes_used_m.empty() || !content.fixes_refused_m.empty())
        text += "  \u00b7  " + grouped(content.fixes_used_m.size()) + " fixes used, " +
                grouped(content.fixes_refused_m.size()) + " not";
    const EarthMoment& end = content.moments.back();
    const Eigen::Vector3d apart_m = end.p_uncorrected_m - end.p_m;
    if (apart_m.allFinite())
        text += "  \u00b7  " + content.uncorrected_name +
                text_of(", the end lies %.2f m", apart_m.head<2>().norm()) + " aside" +
                text_of(" and %.2f m", std::abs(apart_m.z())) + (apart_m.z() < 0 ? " lower" : " higher");
    return text;
}

Curve curve_of(const EarthContent& content, double EarthMoment::*x, double EarthMoment::*y) {
    Curve curve;
    for (const EarthMoment& moment : content.moments) curve.emplace_back(moment.*x, moment.*y);
    return curve;
}

/// One of the four errors, and three of its standard deviations.
struct ErrorPanel {
    Curve error, three_sigma;
    double rms = 0, largest = 0, outside = 0;  ///< outside: part of all
    double usual_band = 0;                     ///< that of all but the least certain twentieth
};

ErrorPanel error_panel(const EarthContent& content, int which, double scale) {
    ErrorPanel panel;
    double squares = 0, count = 0, beyond = 0;
    std::vector<double> bands;
    for (const EarthMoment& moment : content.moments) {
        const double error = scale * moment.error[which], three_sigma = 3 * scale * moment.sigma[which];
        panel.error.emplace_back(moment.time_s, error);
        panel.three_sigma.emplace_back(moment.time_s, three_sigma);
        if (!std::isfinite(error) || !std::isfinite(three_sigma)) continue;
        squares += error * error;
        panel.largest = std::max(panel.largest, std::abs(error));
        beyond += std::abs(error) > three_sigma ? 1 : 0;
        ++count;
        bands.push_back(three_sigma);
    }
    if (bands.empty()) return panel;
    panel.rms = std::sqrt(squares / count);
    panel.outside = beyond / count;
    const auto usual = bands.begin() + static_cast<std::ptrdiff_t>(0.95 * (count - 1));
    std::nth_element(bands.begin(), usual, bands.end());
    panel.usual_band = *usual;
    return panel;
}

}  // namespace

cv::Mat draw_earth_plan(const EarthContent& content, const SceneContent& map, PictureSize size) {
    Figure::Text text;
    text.title = content.title + ": path on the Earth";
    text.subtitle = subtitle_of(content);
    text.axes = true;
    add_lines_to_legend(content, text.legend);
    if (!content.fixes_used_m.empty()) text.legend.push_back({Mark::points, "Fixes used", used});
    if (!content.fixes_refused_m.empty()) text.legend.push_back({Mark::points, "Fixes not used", refused});
    Figure figure(size, text);
    Canvas& canvas = figure.canvas();
    const MapWindow window = fitting_window(bounds_of_paths(content), figure.panel(0));
    canvas.clip(window.box);
    draw_ground(figure, window, map, content.cloud_lies_below);
    figure.graticule(window);
    draw_fixes(figure, window, content.fixes_refused_m, refused);
    draw_paths(figure, window, content);
    draw_fixes(figure, window, content.fixes_used_m, used);
    canvas.unclip();
    figure.frame(0);
    figure.tick_labels(window, true);
    figure.scale_bar(window.px_per_m);
    return figure.finish();
}

cv::Mat draw_earth_heights(const EarthContent& content, PictureSize size) {
    Figure::Text text;
    text.title = content.title + ": height";
    text.subtitle = "metres above the WGS84 ellipsoid, over the way of the result in metres";
    text.axes = true;
    text.scale_in_titles = true;  // no scale bar at the bottom
    add_lines_to_legend(content, text.legend);
    Figure figure(size, text);
    const double u = figure.body_px();
    const Curve result = curve_of(content, &EarthMoment::way_m, &EarthMoment::height_m),
                other = curve_of(content, &EarthMoment::way_m, &EarthMoment::height_uncorrected_m),
                true_path = curve_of(content, &EarthMoment::way_m, &EarthMoment::height_true_m);
    const ChartWindow window = chart_about({result, other, true_path}, figure.panel(0), 0.5);
    draw_chart_axes(figure, window, " m", "");
    figure.canvas().clip(window.box);
    draw_curve(figure, window, true_path, truth, 0.4 * u);
    draw_curve(figure, window, other, without_fixes, 0.24 * u, true);
    draw_curve(figure, window, result, with_fixes, 0.13 * u);
    figure.canvas().unclip();
    figure.frame(0);
    return figure.finish();
}

cv::Mat draw_earth_errors(const EarthContent& content, PictureSize size) {
    const struct {
        const char *name, *unit;
        double scale, least;
    } kinds[] = {{"East", " m", 1, 0.02},
                 {"North", " m", 1, 0.02},
                 {"Up", " m", 1, 0.02},
                 {"Heading", "\u00b0", degrees_per_rad, 0.02}};
    Figure::Text text;
    text.title = content.title + ": error on the Earth";
    text.subtitle = "against the truth, with nothing aligned, over the time of the log in seconds";
    text.axes = true;
    text.columns = 1;
    text.scale_in_titles = true;
    text.legend = {{Mark::line, "Error", with_fixes},
                   {Mark::line, "Within 3 standard deviations", band_colour}};
    std::vector<ErrorPanel> panels;
    for (int i = 0; i < 4; ++i) {
        const auto& kind = kinds[i];
        panels.push_back(error_panel(content, i, kind.scale));
        text.panel_titles.push_back(
            std::string(kind.name) + text_of(": RMS %.3f", panels.back().rms) + kind.unit +
            text_of(", largest %.3f", panels.back().largest) + kind.unit +
            text_of(", %.1f %% of the time outside of the band", 100 * panels.back().outside));
    }
    Figure figure(size, text);
    for (std::size_t i = 0; i < 4; ++i) {
        const ErrorPanel& panel = panels[i];
        ChartWindow window = chart_about({panel.error}, figure.panel(i), 0);
        const double half = std::max({1.08 * panel.largest, 1.08 * panel.usual_band, kinds[i].least});
        window.low.y() = -half;
        window.high.y() = half;
        figure.canvas().clip(window.box);
        draw_band(figure, window, panel.three_sigma, band_colour);
        figure.canvas().unclip();
        draw_chart_axes(figure, window, " s", kinds[i].unit);
        figure.canvas().clip(window.box);
        draw_curve(figure, window, panel.error, with_fixes, 0.12 * figure.body_px());
        figure.canvas().unclip();
        figure.frame(i);
    }
    return figure.finish();
}

}  // namespace loopline
